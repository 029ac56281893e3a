// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>

#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {

// The distance across the line along one of its axes, less an offset and what the tilt makes of the way along it.
GeodeticModel OnLine::model(const ShapePoint& at) {
  GeodeticModel model;
  const Eigen::Vector3d local = at.local();
  const int axis = at.observation.axis;
  model.computed = local[axis] - at.unknowns[0] - at.unknowns[1] * local.z();
  model.by_from = at.shape.axes.col(axis) - at.unknowns[1] * at.shape.axes.col(2);
  model.by_auxiliary = {-1, -local.z(), 0};
  model.auxiliaries = 2;
  return model;
}

std::optional<Eigen::Matrix3d> OnLine::axes(const ShapeSpread& spread) {
  constexpr double kPlumb = 0.999;  // 2.6 degrees off: what is sideways is east
  const Eigen::Vector3d along = spread.along();
  const Eigen::Vector3d sideways =
      (along.z() > kPlumb ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ()).cross(along);
  Eigen::Matrix3d axes;
  axes.col(0) = sideways.normalized();
  axes.col(1) = along.cross(axes.col(0));
  axes.col(2) = along;
  return axes;
}

}  // namespace collinea::geodetic
