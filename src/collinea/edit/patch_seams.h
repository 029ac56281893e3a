// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"

namespace collinea {

struct EditedWork;

/// Takes a part of the orthophoto from a photograph: `patch S1 DJI_1.jpg E N E N E N`. A patch of that name is replaced
/// and lies over all others.
struct PatchSeams {
  static constexpr std::string_view kWord = "patch";
  static constexpr std::string_view kForm = "patch PATCH IMAGE E N E N E N ...";

  std::string patch, image;
  std::vector<Eigen::Vector2d> ring_m;

  static Result<PatchSeams> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<PatchSeams> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Errors: no such image; a ring without an area.
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext& context,
                                                                const EditedWork& before) const;
};

/// Removes a patch: `unpatch S1`.
struct UnpatchSeams {
  static constexpr std::string_view kWord = "unpatch";
  static constexpr std::string_view kForm = "unpatch PATCH";

  std::string patch;

  static Result<UnpatchSeams> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<UnpatchSeams> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Error: no such patch.
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext& context,
                                                                const EditedWork& before) const;
};

}  // namespace collinea
