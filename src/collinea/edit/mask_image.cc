// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/mask_image.h"

#include "collinea/edit/edited_work.h"
#include "collinea/edit/internal/ring_words.h"
#include "collinea/edit/internal/words_in.h"

namespace collinea {
namespace {

std::vector<std::vector<std::string>> commands_of(const EditContext& context, const EditedWork& work,
                                                  const std::string& name) {
  std::vector<std::vector<std::string>> commands;
  for (const ImageMask& one : work.masks)
    if (one.name == name)
      commands.push_back(
          command_words(MaskImage{name, one.image ? context.block().images.at(*one.image).file : "*", one.ring_px}));
  return commands;
}

}  // namespace

Result<MaskImage> MaskImage::parse(std::span<const std::string> words) {
  if (words.size() < 2) return wrong_form(kForm);
  MaskImage one{.mask = words[0], .image = words[1]};
  COLLINEA_TRY(check_new_name(one.mask, "MASK"));
  COLLINEA_TRY(check_name(one.image, "IMAGE"));
  COLLINEA_TRY(one.ring_px, ring_in(words.subspan(2), kForm, "X", "Y"));
  COLLINEA_TRY(check_ring(one.ring_px));
  return one;
}

std::vector<std::string> MaskImage::words() const {
  std::vector<std::string> words = {mask, image};
  append_words(ring_px, words);
  return words;
}

Result<MaskImage> MaskImage::completed(const EditContext& context, const EditDefaults&) const {
  if (image == "*") return *this;
  MaskImage one = *this;
  COLLINEA_TRY(const ImageId id, context.image(image));
  one.image = context.block().images.at(id).file;
  return one;
}

Result<> MaskImage::apply(const EditContext& context, EditedWork& work) const {
  ImageMask made{.name = mask, .image = {}, .ring_px = ring_px};
  if (image != "*") {
    COLLINEA_TRY(made.image, context.image(image));
  }
  std::erase_if(work.masks, [&](const ImageMask& one) { return one.name == mask; });
  work.masks.push_back(std::move(made));
  return {};
}

std::vector<std::vector<std::string>> MaskImage::restoring(const EditContext& context, const EditedWork& before) const {
  auto commands = commands_of(context, before, mask);
  if (commands.empty()) commands.push_back(command_words(UnmaskImage{mask}));
  return commands;
}

Result<UnmaskImage> UnmaskImage::parse(std::span<const std::string> words) {
  if (words.size() != 1) return wrong_form(kForm);
  COLLINEA_TRY(check_name(words[0], "MASK"));
  return UnmaskImage{words[0]};
}

std::vector<std::string> UnmaskImage::words() const { return {mask}; }

Result<UnmaskImage> UnmaskImage::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> UnmaskImage::apply(const EditContext&, EditedWork& work) const {
  const auto removed = std::erase_if(work.masks, [&](const ImageMask& one) { return one.name == mask; });
  if (removed == 0) return fail(Errc::kNotFound, "there is no mask " + mask);
  return {};
}

std::vector<std::vector<std::string>> UnmaskImage::restoring(const EditContext& context,
                                                             const EditedWork& before) const {
  return commands_of(context, before, mask);
}

}  // namespace collinea
