// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/match/window_matching.h"

// Least squares matching from the left image to the right one and back again: what is found must not depend on which
// image is the reference (forward-backward check). docs/theory/least-squares-matching.md.
namespace collinea {

/// A line of an image: a x + b y + c = 0, (a, b) of unit length.
struct ImageLine2 {
  double a = 0, b = 0, c = 0;

  [[nodiscard]] double distance_px(const Eigen::Vector2d& p) const { return a * p.x() + b * p.y() + c; }
  [[nodiscard]] Eigen::Vector2d foot_px(const Eigen::Vector2d& p) const {
    return p - distance_px(p) * Eigen::Vector2d(a, b);
  }
  [[nodiscard]] Eigen::Vector2d direction() const { return {-b, a}; }
};

/// The epipolar line of a point, x_other' F x = 0. Nothing at the epipole, or of a matrix that has no line for it.
[[nodiscard]] std::optional<ImageLine2> epipolar_line(const Eigen::Matrix3d& fundamental, const Eigen::Vector2d& px);

struct ReturnedWindow {
  WindowMatch match;                       ///< in the right image; kNotReturned where the way back fails
  std::optional<double> returned_px = {};  ///< from the point, where the way back found an answer
};

/// match_window(), then the window round what was found in the right image, matched in the left one: it begins at the
/// point, under the inverse map, with the same options. The way back must find an answer within `return_px` of the
/// point. `left_line`: of the model kLine, the direction of the line in the left image along which it goes back; the
/// distance is then along it. The noise is that of the way there, and so is the covariance: both ways see the same
/// pixels.
[[nodiscard]] ReturnedWindow match_window_and_back(const GreyImage& left, const Eigen::Vector2d& left_px,
                                                   const GreyImage& right, const WindowStart& start,
                                                   const WindowOptions& options, const Eigen::Vector2d& left_line,
                                                   double return_px);

}  // namespace collinea
