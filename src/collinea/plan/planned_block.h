// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/plan/control_layout.h"
#include "collinea/plan/internal/flight_plan.h"
#include "collinea/quality/examine.h"

namespace collinea {

/// What will be measured, and how well.
struct MeasurementOptions {
  int points_per_image = 200;
  double found_share = 0.5;
  double sigma_px = 0.5, control_sigma_px = 0.5;
  std::optional<double> position_sigma_plan_m = {}, position_sigma_height_m = {};
  double position_shift_m = 0;
  Calibration calibration = Calibration::kBrown;
  double focal_sigma = 0.05;
  std::optional<double> map_cell_m = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = MeasurementOptions;
    visit(Field{"points_per_image", &O::points_per_image, "1", "tie points found in an image", 8, 10000});
    visit(Field{"found_share", &O::found_share, "1", "chance that a tie point is found in an image that shows it", 0.05,
                1});
    visit(Field{"sigma_px", &O::sigma_px, "px", "standard deviation of a coordinate of a tie point", 0.001, 100});
    visit(Field{"control_sigma_px", &O::control_sigma_px, "px", "the same of control and check points", 0.001, 100});
    visit(Field{"position_sigma_plan_m", &O::position_sigma_plan_m, "m",
                "of the east and north of each projection centre by GNSS; nothing: they are not used", 1e-4, 1000});
    visit(Field{"position_sigma_height_m", &O::position_sigma_height_m, "m",
                "of its height; nothing: one and a half times that in plan", 1e-4, 1000});
    visit(
        Field{"position_shift_m", &O::position_shift_m, "m",
              "standard deviation of a shift that all positions have in common: of the base station, the antenna, the "
              "geoid",
              0, 1000});
    visit(Field{"calibration", &O::calibration, "", "camera parameters found with the block"});
    visit(Field{"focal_sigma", &O::focal_sigma, "1", "standard deviation of the focal length before that, relative",
                1e-6, 1});
    visit(Field{"map_cell_m", &O::map_cell_m, "m",
                "cells of the map of standard deviations; nothing: about 500 of a round size", 0.01, 1e5});
  }
};

/// Square cells over the area, from west to east and north to south, for each of which a precision is predicted.
struct PrecisionGrid {
  double west_m = 0, north_m = 0, cell_m = 1;
  int width = 0, height = 0;

  [[nodiscard]] Eigen::Vector2d centre(std::size_t cell) const;
  [[nodiscard]] std::size_t size() const { return std::size_t(width) * std::size_t(height); }
};
[[nodiscard]] PrecisionGrid precision_grid(const MapArea& area, std::optional<double> cell_m);

/// A block as it would be measured, without errors: the bundle's engine then says what the errors would do.
struct PlannedBlock {
  Block block;  ///< the world frame: plan coordinates less `origin`
  AdjustScope scope;
  ExamineOptions options;
  Eigen::Vector2d origin;
  PrecisionGrid grid;
  std::map<ControlId, std::size_t> cells;  ///< check points without a survey at the centres of the grid's cells
};

/// Poses as planned but for what wind and gimbal do, tie points spread evenly, control and cells of the grid measured
/// in every image that shows them. Tie points stay the same when strips or control are added. Errors: options out of
/// range.
[[nodiscard]] Result<PlannedBlock> planned_block(const FlightPlan& plan, const std::vector<PlannedPoint>& points,
                                                 const MeasurementOptions& options);

/// The same block with one draw of all errors: image points, surveys, positions, the camera as it is known before.
[[nodiscard]] PlannedBlock with_errors(PlannedBlock planned, std::uint64_t seed);

}  // namespace collinea
