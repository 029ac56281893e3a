// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/geodetic_model.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace collinea {

GeodeticModel geodetic_model(const GeodeticObservation& observation, const Eigen::Vector3d& from,
                             const Eigen::Vector3d& to, double orientation_rad, bool level_at_origin) {
  const Eigen::Vector3d up = geodetic::up_at(from, level_at_origin), up_there = geodetic::up_at(to, level_at_origin);
  const Eigen::Vector3d line =
      to - from + observation.target_height_m * up_there - observation.instrument_height_m * up;
  const geodetic::Sight sight{observation, from, to, up, up_there, line, orientation_rad, level_at_origin};
  switch (observation.kind) {
    case GeodeticKind::kDistance:
      return geodetic::Distance::model(sight);
    case GeodeticKind::kHeightDifference:
      return geodetic::HeightDifference::model(sight);
    case GeodeticKind::kDirection:
      return geodetic::Direction::model(sight);
    case GeodeticKind::kZenithAngle:
      return geodetic::ZenithAngle::model(sight);
    case GeodeticKind::kAtHeight:
    case GeodeticKind::kOnPlane:
    case GeodeticKind::kOnLine:
      break;  // shape_model() knows these
  }
  return {};
}

std::optional<GeodeticShape> shape_through(GeodeticKind kind, const std::vector<Eigen::Vector3d>& points) {
  if (static_cast<int>(points.size()) < points_of_shape(kind)) return std::nullopt;
  GeodeticShape shape;
  if (kind == GeodeticKind::kAtHeight) return shape;
  for (const Eigen::Vector3d& point : points) shape.origin += point / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points) scatter += (point - shape.origin) * (point - shape.origin).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  const geodetic::ShapeSpread spread{eigen.eigenvalues(), eigen.eigenvectors()};
  if (!(spread.length2[2] > 0) || !std::isfinite(spread.length2[2])) return std::nullopt;
  const auto axes = kind == GeodeticKind::kOnPlane ? geodetic::OnPlane::axes(spread) : geodetic::OnLine::axes(spread);
  if (!axes) return std::nullopt;
  shape.axes = *axes;
  return shape;
}

GeodeticModel shape_model(const GeodeticObservation& observation, const GeodeticShape& shape, const double* unknowns,
                          const Eigen::Vector3d& point, bool level_at_origin) {
  const geodetic::ShapePoint at{observation, shape, unknowns, point, level_at_origin};
  if (observation.kind == GeodeticKind::kAtHeight) return geodetic::CommonHeight::model(at);
  return observation.kind == GeodeticKind::kOnPlane ? geodetic::OnPlane::model(at) : geodetic::OnLine::model(at);
}

double geodetic_residual(const GeodeticObservation& observation, const GeodeticModel& model) {
  const double residual = observation.value - model.computed;
  return observation.is_angle() ? std::remainder(residual, 2 * std::numbers::pi) : residual;
}

}  // namespace collinea
