// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/patch_seams.h"

#include "collinea/edit/edited_work.h"
#include "collinea/edit/internal/ring_words.h"
#include "collinea/edit/internal/words_in.h"

namespace collinea {
namespace {

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
  if (words.size() < 2) return wrong_form(kForm);
  PatchSeams one{.patch = words[0], .image = words[1]};
  COLLINEA_TRY(check_new_name(one.patch, "PATCH"));
  COLLINEA_TRY(check_name(one.image, "IMAGE"));
  COLLINEA_TRY(one.ring_m, ring_in(words.subspan(2), kForm, "E", "N"));
  COLLINEA_TRY(check_ring(one.ring_m));
  return one;
}

std::vector<std::string> PatchSeams::words() const {
  std::vector<std::string> words = {patch, image};
  append_words(ring_m, words);
  return words;
}

Result<PatchSeams> PatchSeams::completed(const EditContext& context, const EditDefaults&) const {
  PatchSeams one = *this;
  COLLINEA_TRY(const ImageId id, context.image(image));
  one.image = context.block().images.at(id).file;
  return one;
}

Result<> PatchSeams::apply(const EditContext& context, EditedWork& work) const {
  SeamPatch made{.name = patch, .ring_m = ring_m};
  COLLINEA_TRY(made.image, context.image(image));
  std::erase_if(work.patches, [&](const SeamPatch& one) { return one.name == patch; });
  work.patches.push_back(std::move(made));
  return {};
}

std::vector<std::vector<std::string>> PatchSeams::restoring(const EditContext& context,
                                                            const EditedWork& before) const {
  auto commands = commands_of(context, before, patch);
  if (commands.empty()) commands.push_back(command_words(UnpatchSeams{patch}));
  return commands;
}

Result<UnpatchSeams> UnpatchSeams::parse(std::span<const std::string> words) {
  if (words.size() != 1) return wrong_form(kForm);
  COLLINEA_TRY(check_name(words[0], "PATCH"));
  return UnpatchSeams{words[0]};
}

std::vector<std::string> UnpatchSeams::words() const { return {patch}; }

Result<UnpatchSeams> UnpatchSeams::completed(const EditContext&, const EditDefaults&) const { return *this; }

Result<> UnpatchSeams::apply(const EditContext&, EditedWork& work) const {
  const auto removed = std::erase_if(work.patches, [&](const SeamPatch& one) { return one.name == patch; });
  if (removed == 0) return fail(Errc::kNotFound, "there is no patch " + patch);
  return {};
}

std::vector<std::vector<std::string>> UnpatchSeams::restoring(const EditContext& context,
                                                              const EditedWork& before) const {
  return commands_of(context, before, patch);
}

}  // namespace collinea
