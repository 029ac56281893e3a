// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace collinea {

/// A circle of the plane.
struct FittedCircle {
  Eigen::Vector2d centre;
  double radius = 0;
  double conditioning = 0;  ///< of the equations, smallest over largest eigenvalue: 0 of points on a line
};

/// The circle x^2 + y^2 = 2 a x + 2 b y + c by least squares of that equation: through three points exactly. Points lie
/// about the origin, better conditioned the nearer their distances are to 1. Nothing where no circle is left.
[[nodiscard]] std::optional<FittedCircle> algebraic_circle(std::span<const Eigen::Vector2d> points);

}  // namespace collinea
