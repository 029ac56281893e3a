// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"

namespace collinea {

/// Makes a point a control point, or one that is only compared: `role P1 check`.
struct SetRole {
  static constexpr std::string_view kWord = "role";
  static constexpr std::string_view kForm = "role NAME control|check";

  std::string point;
  ControlRole role = ControlRole::kControl;

  static Result<SetRole> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<SetRole> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Error: no such point.
  Result<> apply(const EditContext& context, EditedPoint& edited) const;
};

}  // namespace collinea
