// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"

namespace collinea {

struct EditedWork;

/// Masks a part of a photograph, or of all (`*`): `mask M1 DJI_1.jpg 10 20 300 20 300 400`. A mask of that name is
/// replaced.
struct MaskImage {
  static constexpr std::string_view kWord = "mask";
  static constexpr std::string_view kForm = "mask MASK IMAGE|* X Y X Y X Y ...";

  std::string mask, image;
  std::vector<Eigen::Vector2d> ring_px;

  static Result<MaskImage> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<MaskImage> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Errors: no such image; a ring without an area.
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext& context,
                                                                const EditedWork& before) const;
};

/// Removes a mask: `unmask M1`.
struct UnmaskImage {
  static constexpr std::string_view kWord = "unmask";
  static constexpr std::string_view kForm = "unmask MASK";

  std::string mask;

  static Result<UnmaskImage> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<UnmaskImage> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Error: no such mask.
  Result<> apply(const EditContext& context, EditedWork& work) const;
  [[nodiscard]] std::vector<std::vector<std::string>> restoring(const EditContext& context,
                                                                const EditedWork& before) const;
};

}  // namespace collinea
