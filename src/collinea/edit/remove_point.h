// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"

namespace collinea {

/// Removes a point with its marks: `remove P1`.
struct RemovePoint {
  static constexpr std::string_view kWord = "remove";
  static constexpr std::string_view kForm = "remove POINT";

  std::string point;

  static Result<RemovePoint> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<RemovePoint> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Errors: no such point; measurements on the ground that name it.
  Result<> apply(const EditContext& context, EditedPoint& edited) const;
};

}  // namespace collinea
