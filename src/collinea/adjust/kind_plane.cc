// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>

#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

// The distance along the tilted normal (t1, t2, 1) of the frame, less the offset.
GeodeticModel OnPlane::model(const ShapePoint& at) {
  GeodeticModel model;
  const Eigen::Vector3d local = at.local(), across(at.unknowns[1], at.unknowns[2], 1);
  const double length = across.norm(), height = across.dot(local) / length;
  model.computed = height - at.unknowns[0];
  model.by_from = at.shape.axes * (across / length);
  model.by_auxiliary = {-1, (local.x() - height * at.unknowns[1] / length) / length,
                        (local.y() - height * at.unknowns[2] / length) / length};
  model.auxiliaries = 3;
  return model;
}

std::optional<Eigen::Matrix3d> OnPlane::axes(const ShapeSpread& spread) {
  constexpr double kNarrow = 1e-3;
  if (!(spread.length2[1] > kNarrow * kNarrow * spread.length2[2])) return std::nullopt;
  const Eigen::Vector3d along = spread.along();
  Eigen::Matrix3d axes;
  axes.col(2) = spread.directions.col(0);
  axes.col(0) = along;
  axes.col(1) = axes.col(2).cross(along);
  return axes;
}

}  // namespace collinea::geodetic
