// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/geodetic_kinds.h"

#include <Eigen/Geometry>

namespace collinea::geodetic {
namespace {

// From the middle of the Earth.
Eigen::Vector3d from_middle(const Eigen::Vector3d& point) { return {point.x(), point.y(), point.z() + kEarthRadius_m}; }

}  // namespace

// Its change along the line of sight is below 1e-6 of the effect itself: the derivatives take it as constant.
Eigen::Vector3d normal_at(const Eigen::Vector3d& point, const Earth& earth) {
  return earth.is_round ? from_middle(point).normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
}

Eigen::Vector3d up_at(const Eigen::Vector3d& point, const Earth& earth) {
  const Eigen::Vector3d normal = normal_at(point, earth);
  if (earth.deflection_rad.isZero(0)) return normal;
  const Eigen::Vector3d east = earth.pole.cross(normal).normalized(), north = normal.cross(east);
  return (normal + earth.deflection_rad[0] * north + earth.deflection_rad[1] * east).normalized();
}

// |P| - R without the loss of digits of a difference of two large numbers.
double height_of(const Eigen::Vector3d& point, const Earth& earth) {
  if (!earth.is_round) return point.z();
  const double radius = from_middle(point).norm();
  const double height = (point.squaredNorm() + 2 * kEarthRadius_m * point.z()) / (radius + kEarthRadius_m);
  // Levels fall by the deflection along it (dN = -xi dy - eta dx, Helmert): heights above them grow.
  return height + earth.deflection_rad[0] * point.y() + earth.deflection_rad[1] * point.x();
}

void derive_by_line(GeodeticModel& model, const Eigen::Vector3d& derivative) {
  model.by_to = derivative;
  model.by_from = -derivative;
}

Eigen::Vector3d ShapeSpread::along() const {
  const Eigen::Vector3d longest = directions.col(2);
  return longest.z() < 0 ? Eigen::Vector3d(-longest) : longest;
}

}  // namespace collinea::geodetic
