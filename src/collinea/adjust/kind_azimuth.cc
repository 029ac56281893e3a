// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>

#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

// a = atan2(e, n) of the line of sight: da = (n de - e dn) / (e^2 + n^2). A gyro or the sun has no set-up to orient.
// How north changes with the instrument's own position counts too little for the derivatives.
GeodeticModel Azimuth::model(const Sight& sight) {
  GeodeticModel model;
  const Eigen::Vector3d east = sight.earth.pole.cross(sight.up).normalized(), north = sight.up.cross(east);
  const double e = sight.line.dot(east), n = sight.line.dot(north), squared = e * e + n * n;
  model.computed = std::atan2(e, n);
  if (squared > 0) derive_by_line(model, (n * east - e * north) / squared);
  return model;
}

}  // namespace collinea::geodetic
