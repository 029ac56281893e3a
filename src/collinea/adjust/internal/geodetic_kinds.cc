// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/geodetic_kinds.h"

namespace collinea::geodetic {
namespace {

// From the middle of the Earth.
Eigen::Vector3d from_middle(const Eigen::Vector3d& point) { return {point.x(), point.y(), point.z() + kEarthRadius_m}; }

}  // namespace

// Its change along the line of sight is below 1e-6 of the effect itself: the derivatives take it as constant.
Eigen::Vector3d up_at(const Eigen::Vector3d& point, const Earth& earth) {
  return earth.is_round ? from_middle(point).normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
}

// |P| - R without the loss of digits of a difference of two large numbers.
double height_of(const Eigen::Vector3d& point, const Earth& earth) {
  if (!earth.is_round) return point.z();
  const double radius = from_middle(point).norm();
  return (point.squaredNorm() + 2 * kEarthRadius_m * point.z()) / (radius + kEarthRadius_m);
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
