// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

namespace {

constexpr double kRefraction = 0.13;  // radius of the Earth over that of the line of sight (Gauss)

}  // namespace

// z = atan2(s, h) with the level length s and the height h of the line of sight: dz = (h ds - s dh) / (s^2 + h^2).
GeodeticModel ZenithAngle::model(const Sight& sight) {
  GeodeticModel model;
  const double height = sight.line.dot(sight.up);
  const Eigen::Vector3d level = sight.line - height * sight.up;
  const double across = level.norm(), squared = sight.line.squaredNorm();
  model.computed = std::atan2(across, height);
  if (sight.earth.is_round) model.computed -= kRefraction * across / (2 * kEarthRadius_m);
  if (across > 0) derive_by_line(model, (height / across * level - across * sight.up) / squared);
  return model;
}

}  // namespace collinea::geodetic
