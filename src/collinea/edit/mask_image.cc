// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/mask_image.h"

#include "collinea/edit/edited_work.h"
#include "collinea/edit/internal/named_areas.h"
#include "collinea/edit/internal/words_in.h"

namespace collinea {
namespace {

// What makes the mask of a name as it was; nothing where there was none.
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
  return named_area_in(words, kForm, "MASK", "X", "Y").map([](NamedArea area) {
    return MaskImage{std::move(area.name), std::move(area.image), std::move(area.ring)};
  });
}

std::vector<std::string> MaskImage::words() const { return words_of_area(mask, image, ring_px); }

Result<MaskImage> MaskImage::completed(const EditContext& context, const EditDefaults&) const {
  if (image == "*") return *this;
  MaskImage one = *this;
  COLLINEA_TRY(one.image, file_named(context, image));
  return one;
}

Result<> MaskImage::apply(const EditContext& context, EditedWork& work) const {
  ImageMask made{.name = mask, .image = {}, .ring_px = ring_px};
  if (image != "*") {
    COLLINEA_TRY(made.image, context.image(image));
  }
  put_on_top(work.masks, std::move(made));
  return {};
}

std::vector<std::vector<std::string>> MaskImage::restoring(const EditContext& context, const EditedWork& before) const {
  auto commands = commands_of(context, before, mask);
  if (commands.empty()) commands.push_back(command_words(UnmaskImage{mask}));
  return commands;
}

Result<UnmaskImage> UnmaskImage::parse(std::span<const std::string> words) {
  return known_name_in(words, kForm, "MASK").map([](std::string name) { return UnmaskImage{std::move(name)}; });
}

std::vector<std::string> UnmaskImage::words() const { return {mask}; }

Result<UnmaskImage> UnmaskImage::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> UnmaskImage::apply(const EditContext&, EditedWork& work) const {
  return remove_named(work.masks, mask, "mask");
}

std::vector<std::vector<std::string>> UnmaskImage::restoring(const EditContext& context,
                                                             const EditedWork& before) const {
  return commands_of(context, before, mask);
}

}  // namespace collinea
