// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_point.h"

namespace collinea {

/// Adds a control or check point, or changes it and keeps its marks: `point P1 check 500100.5 5300000 420 0.02 0.02
/// 0.03`. Coordinates are those of the map of the project; "-" stands for what is not known.
struct SetPoint {
  static constexpr std::string_view kWord = "point";
  static constexpr std::string_view kForm = "point NAME control|check E N H [SE SN SH]";

  std::string point;
  ControlRole role = ControlRole::kControl;
  std::array<std::optional<double>, 3> position_in_map = {};  ///< easting, northing, height [m]
  /// Of easting, northing and height; infinite where not known, nothing: not completed yet.
  std::optional<Eigen::Vector3d> sigma_m;

  static Result<SetPoint> parse(std::span<const std::string> words);
  [[nodiscard]] std::vector<std::string> words() const;
  [[nodiscard]] Result<SetPoint> completed(const EditContext& context, const EditDefaults& defaults) const;
  /// Errors: coordinates in a project without a map, or far outside of it.
  Result<> apply(const EditContext& context, EditedPoint& edited) const;
};

/// The command that gives a point again what SetPoint can say of it.
[[nodiscard]] SetPoint set_point_of(const ControlPoint& point);

/// "control" or "check".
[[nodiscard]] Result<ControlRole> role_in(const std::string& word);
[[nodiscard]] std::string word_of_role(ControlRole role);

}  // namespace collinea
