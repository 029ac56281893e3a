// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/LU>
#include <optional>

#include "collinea/match/correlation_surface.h"

namespace collinea {

/// The surface of second degree through what 3 x 3 positions leave unexplained, by least squares.
struct PeakParaboloid {
  double middle = 0;      ///< its value at the pixel
  Eigen::Vector2d slope;  ///< there
  Eigen::Matrix2d hesse;

  /// Where it is least, from the pixel; nothing where it has no such point.
  [[nodiscard]] std::optional<Eigen::Vector2d> lowest() const {
    if (!(hesse(0, 0) > 0 && hesse.determinant() > 1e-12 * hesse(0, 0) * hesse(1, 1))) return std::nullopt;
    return Eigen::Vector2d(-hesse.inverse() * slope);
  }
  /// Its value at lowest().
  [[nodiscard]] double value_at(const Eigen::Vector2d& lowest) const { return middle + 0.5 * slope.dot(lowest); }
};

/// Round the value in this column and row of the surface, which has all its neighbours: of the residual sum of squares
/// (of sad, rank and census the sum itself). Of ncc and cosine with the gain at that position.
[[nodiscard]] PeakParaboloid peak_paraboloid(const CorrelationSurface& surface, int column, int row);

}  // namespace collinea
