// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "collinea/block/geodetic.h"
#include "collinea/io/control_file.h"
#include "collinea/plan/internal/flight_plan.h"

namespace collinea {

/// Positions of control that follow from the area.
enum class ControlPattern { kNone, kCorners, kCornersMiddle, kGrid };
inline constexpr Word<ControlPattern> kControlPatternWords[] = {{ControlPattern::kNone, "none"},
                                                                {ControlPattern::kCorners, "corners"},
                                                                {ControlPattern::kCornersMiddle, "corners_middle"},
                                                                {ControlPattern::kGrid, "grid"}};
[[nodiscard]] constexpr std::span<const Word<ControlPattern>> words(ControlPattern) { return kControlPatternWords; }

/// Where control is to be laid out, and how well it is surveyed.
struct LayoutOptions {
  WordOr<ControlPattern, std::filesystem::path> control = ControlPattern::kCornersMiddle;
  int control_points = 9;
  double control_sigma_plan_m = 0.01, control_sigma_height_m = 0.015;
  std::optional<double> control_inset_m = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = LayoutOptions;
    visit(Field{"control", &O::control, "",
                "none | corners | corners_middle | grid (of about control_points) | a file as import takes it, whose "
                "points with role check are predicted"}
              .leads_to(PathKind::kFileOrWord));
    visit(Field{"control_points", &O::control_points, "1", "points of the grid", 1, 10000});
    visit(Field{"control_sigma_plan_m", &O::control_sigma_plan_m, "m",
                "of surveyed east and north, where the file states none", 1e-5, 100});
    visit(Field{"control_sigma_height_m", &O::control_sigma_height_m, "m", "of surveyed heights", 1e-5, 100});
    visit(Field{"control_inset_m", &O::control_inset_m, "m",
                "from the border to the outermost points; nothing: a twentieth of the shorter side", 0, 1e5});
  }
};

/// A point to be surveyed, in plan coordinates.
struct PlannedPoint {
  std::string name;
  ControlRole role = ControlRole::kControl;
  Eigen::Vector2d position;
  Eigen::Vector3d sigma_m;  ///< east, north, height; infinite: not surveyed
};

/// The layout of the words; of a file see planned_points(). Corners: the four points of the area farthest out between
/// the directions of the strips and across. Errors: options out of range, a word that is none.
[[nodiscard]] Result<std::vector<PlannedPoint>> lay_out(const LayoutOptions& options, const FlightPlan& plan);
/// Those of a control file. Error: one has a covariance, which is not planned with.
[[nodiscard]] Result<std::vector<PlannedPoint>> planned_points(const ControlFile& file);

}  // namespace collinea
