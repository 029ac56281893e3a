// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace collinea::film {

/// Parameters by their place, of the models that have them.
enum Parameter : int { kColumn, kRow, kRotation, kScaleX, kScaleY, kShear, kPerspectiveX, kPerspectiveY, kParameters };

/// A rotation from the column towards the row.
[[nodiscard]] inline Eigen::Matrix2d turned_by(double angle) {
  Eigen::Matrix2d rotation;
  rotation << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return rotation;
}

/// The film coordinates as the scanner sees them: y down, or up of a photograph scanned from its back.
[[nodiscard]] inline Eigen::Vector2d turned(const Eigen::Vector2d& film_mm, bool is_mirrored) {
  return {film_mm.x(), is_mirrored ? film_mm.y() : -film_mm.y()};
}

}  // namespace collinea::film
