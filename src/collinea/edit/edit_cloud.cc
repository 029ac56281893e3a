// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/edit_cloud.h"

#include "collinea/edit/edited_work.h"
#include "collinea/edit/internal/ring_words.h"
#include "collinea/edit/internal/words_in.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

Result<std::optional<double>> height_in(const std::string& word, std::string_view what) {
  if (word == "-") return std::nullopt;
  return number_in(word, what).map([](double height) { return std::optional(height); });
}

// LOW HIGH E N E N E N ...
Result<CloudRegion> region_in(std::span<const std::string> words, std::string_view form, CloudAction action) {
  if (words.size() < 2) return wrong_form(form);
  CloudRegion region{.action = action};
  COLLINEA_TRY(region.low_m, height_in(words[0], "LOW"));
  COLLINEA_TRY(region.high_m, height_in(words[1], "HIGH"));
  if (region.low_m && region.high_m && *region.low_m > *region.high_m)
    return fail(Errc::kBadInput, "LOW: the lowest height " + words[0] + " lies above the highest, " + words[1]);
  COLLINEA_TRY(region.ring_m, ring_in(words.subspan(2), form, "E", "N"));
  COLLINEA_TRY(check_ring(region.ring_m));
  return region;
}

std::vector<std::string> words_of_region(const CloudRegion& region) {
  std::vector<std::string> words;
  for (const auto& height : {region.low_m, region.high_m}) words.push_back(height ? exact(*height) : "-");
  append_words(region.ring_m, words);
  return words;
}

Result<std::uint8_t> class_in(const std::string& word) {
  COLLINEA_TRY(const double number, number_in(word, "CLASS"));
  if (number < 0 || number > 255 || number != double(int(number)))
    return fail(Errc::kBadInput, "CLASS: \"" + word + "\" is no class of LAS: a whole number from 0 to 255");
  return std::uint8_t(number);
}

}  // namespace

Result<> EditsCloud::apply(const EditContext&, EditedWork& work) const {
  work.regions.push_back(region);
  return {};
}

Result<ClassifyCloud> ClassifyCloud::parse(std::span<const std::string> words) {
  if (words.empty()) return wrong_form(kForm);
  COLLINEA_TRY(const std::uint8_t classification, class_in(words[0]));
  COLLINEA_TRY(CloudRegion region, region_in(words.subspan(1), kForm, CloudAction::kClassify));
  region.classification = classification;
  return ClassifyCloud{{std::move(region)}};
}

std::vector<std::string> ClassifyCloud::words() const {
  std::vector<std::string> words = words_of_region(region);
  words.insert(words.begin(), std::to_string(region.classification));
  return words;
}

Result<CutCloud> CutCloud::parse(std::span<const std::string> words) {
  COLLINEA_TRY(CloudRegion region, region_in(words, kForm, CloudAction::kCut));
  return CutCloud{{std::move(region)}};
}

std::vector<std::string> CutCloud::words() const { return words_of_region(region); }

Result<CropCloud> CropCloud::parse(std::span<const std::string> words) {
  COLLINEA_TRY(CloudRegion region, region_in(words, kForm, CloudAction::kCrop));
  return CropCloud{{std::move(region)}};
}

std::vector<std::string> CropCloud::words() const { return words_of_region(region); }

}  // namespace collinea
