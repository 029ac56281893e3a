// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>

#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

// The azimuth a = atan2(e, n) of the line of sight less the orientation o: da = (n de - e dn) / (e^2 + n^2).
GeodeticModel Direction::model(const Sight& sight) {
  GeodeticModel model;
  const Eigen::Vector3d& up = sight.up;
  const Eigen::Vector3d& line = sight.line;
  const Eigen::Vector3d east = Eigen::Vector3d::UnitY().cross(up).normalized(), north = up.cross(east);
  const double e = line.dot(east), n = line.dot(north), squared = e * e + n * n;
  model.computed = std::atan2(e, n) - sight.orientation_rad;
  model.by_auxiliary[0] = -1;
  model.auxiliaries = 1;
  if (squared > 0) derive_by_line(model, (n * east - e * north) / squared);
  return model;
}

}  // namespace collinea::geodetic
