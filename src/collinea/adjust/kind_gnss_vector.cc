// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>

#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

// The part of the line along a direction that is known: its derivative is that direction. East, north and up of a
// receiver are those of the ellipsoid at `from`; how they turn with that point counts too little for the derivatives.
GeodeticModel GnssVector::model(const Sight& sight) {
  GeodeticModel model;
  Eigen::Vector3d along = sight.observation.along;
  if (sight.observation.is_local) {
    const Eigen::Vector3d up = normal_at(sight.from, sight.earth), east = sight.earth.pole.cross(up).normalized();
    along = east * along.x() + up.cross(east) * along.y() + up * along.z();
  }
  model.computed = along.dot(sight.line);
  derive_by_line(model, along);
  return model;
}

}  // namespace collinea::geodetic
