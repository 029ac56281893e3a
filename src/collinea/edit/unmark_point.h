// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"

namespace collinea {

/// Removes all marks of a control point in an image: `unmark P1 DJI_1.jpg`.
struct UnmarkPoint {
  static constexpr std::string_view kWord = "unmark";
  static constexpr std::string_view kForm = "unmark POINT IMAGE";

  std::string point, image;

  static Result<UnmarkPoint> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<UnmarkPoint> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Errors: no such mark.
  Result<> apply(const EditContext& context, EditedPoint& edited) const;
};

}  // namespace collinea
