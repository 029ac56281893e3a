// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/patch_seams.h"

#include "collinea/edit/edited_work.h"
#include "collinea/edit/internal/named_areas.h"
#include "collinea/edit/internal/words_in.h"

namespace collinea {
namespace {

// What makes the patch of a name as it was; nothing where there was none.
std::vector<std::vector<std::string>> commands_of(const EditContext& context, const EditedWork& work,
                                                  const std::string& name) {
  std::vector<std::vector<std::string>> commands;
  for (const SeamPatch& one : work.patches)
    if (one.name == name)
      commands.push_back(command_words(PatchSeams{name, context.block().images.at(one.image).file, one.ring_m}));
  return commands;
}

}  // namespace

Result<PatchSeams> PatchSeams::parse(std::span<const std::string> words) {
  return named_area_in(words, kForm, "PATCH", "E", "N").map([](NamedArea area) {
    return PatchSeams{std::move(area.name), std::move(area.image), std::move(area.ring)};
  });
}

std::vector<std::string> PatchSeams::words() const { return words_of_area(patch, image, ring_m); }

Result<PatchSeams> PatchSeams::completed(const EditContext& context, const EditDefaults&) const {
  PatchSeams one = *this;
  COLLINEA_TRY(one.image, file_named(context, image));
  return one;
}

Result<> PatchSeams::apply(const EditContext& context, EditedWork& work) const {
  SeamPatch made{.name = patch, .image = {}, .ring_m = ring_m};
  COLLINEA_TRY(made.image, context.image(image));
  put_on_top(work.patches, std::move(made));
  return {};
}

std::vector<std::vector<std::string>> PatchSeams::restoring(const EditContext& context,
                                                            const EditedWork& before) const {
  auto commands = commands_of(context, before, patch);
  if (commands.empty()) commands.push_back(command_words(UnpatchSeams{patch}));
  return commands;
}

Result<UnpatchSeams> UnpatchSeams::parse(std::span<const std::string> words) {
  return known_name_in(words, kForm, "PATCH").map([](std::string name) { return UnpatchSeams{std::move(name)}; });
}

std::vector<std::string> UnpatchSeams::words() const { return {patch}; }

Result<UnpatchSeams> UnpatchSeams::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> UnpatchSeams::apply(const EditContext&, EditedWork& work) const {
  return remove_named(work.patches, patch, "patch");
}

std::vector<std::vector<std::string>> UnpatchSeams::restoring(const EditContext& context,
                                                              const EditedWork& before) const {
  return commands_of(context, before, patch);
}

}  // namespace collinea
