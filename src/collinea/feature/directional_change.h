// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace collinea {

/// A shift of the analytic form of Moravec's operator: the change of a window towards it is sum (u I_x + v I_y)^2.
struct DirectedShift {
  double u = 0, v = 0;  ///< [px]
};

/// The shift towards a direction w (from the v axis, u / v = tan w), written with |u| + |v| = 1 as Karfis does (2.2.2):
/// 45 degrees are (0.5, 0.5). Diagonal shifts are thus shorter, by sqrt(2), than those along the axes.
[[nodiscard]] inline DirectedShift shift_towards(double direction_rad) {
  const double u = std::sin(direction_rad), v = std::cos(direction_rad), sum = std::abs(u) + std::abs(v);
  return {u / sum, v / sum};
}

/// Change of a window with the sums of products of its gradients xx, xy, yy (the structure tensor) [grey^2]: what
/// Moravec's sum of squared differences over the shift is where grey values are linear.
[[nodiscard]] inline double change_towards(DirectedShift shift, double xx, double xy, double yy) {
  return shift.u * shift.u * xx + 2 * shift.u * shift.v * xy + shift.v * shift.v * yy;
}

}  // namespace collinea
