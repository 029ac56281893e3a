// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/feature/hough.h"

namespace collinea {

struct LineCornerOptions {
  double least_angle_deg = 20;
  double reach_px = 10;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = LineCornerOptions;
    visit(Field{"least_angle_deg", &O::least_angle_deg, "deg", "of corners: least angle between their lines", 1, 90});
    visit(Field{"reach_px", &O::reach_px, "px",
                "of corners: largest distance from the nearest edge point of either line", 0, 1e5});
  }
};

/// Where two straight edges meet.
struct LineCorner {
  std::size_t first = 0, second = 0;  ///< the lines, by their order
  Eigen::Vector2d at = {};
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of x, y [px]
  double angle_rad = 0;                                  ///< between the lines, 0 .. pi/2
  double gap_px = 0;  ///< to the nearest edge point of the line that ends farther from it
};

/// Corners as intersections of lines: n_i' x = r_i, n_i = (cos theta_i, sin theta_i), i = 1, 2; with t_i = (-sin, cos)'
/// x the covariance is N^-1 diag(c_i) N^-T, c_i = var(r_i) - 2 t_i cov(theta_i, r_i) + t_i^2 var(theta_i), lines being
/// independent. Unlike a corner of gradients it is not drawn to its inside by blur, since lines are adjusted over their
/// whole length; a corner need not be seen itself, but both lines must have edge points near it: lines go on through
/// gaps, and most of their intersections are none of the object. `points`: those that the lines name by their numbers.
/// In the order of the lines.
[[nodiscard]] std::vector<LineCorner> line_corners(std::span<const FoundLine> lines, std::span<const EdgePoint> points,
                                                   const LineCornerOptions& options);

}  // namespace collinea
