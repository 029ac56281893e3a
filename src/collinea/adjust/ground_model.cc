// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/ground_model.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace collinea {

GroundModel ground_model(const GroundObservation& observation, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                         double orientation_rad, bool level_at_origin) {
  const Eigen::Vector3d up = geodetic::up_at(from, level_at_origin), up_there = geodetic::up_at(to, level_at_origin);
  const Eigen::Vector3d line =
      to - from + observation.target_height_m * up_there - observation.instrument_height_m * up;
  const geodetic::Sight sight{observation, from, to, up, up_there, line, orientation_rad, level_at_origin};
  switch (observation.kind) {
    case GroundKind::kDistance:
      return geodetic::Distance::model(sight);
    case GroundKind::kHeightDifference:
      return geodetic::HeightDifference::model(sight);
    case GroundKind::kDirection:
      return geodetic::Direction::model(sight);
    case GroundKind::kZenithAngle:
      return geodetic::ZenithAngle::model(sight);
    case GroundKind::kAtHeight:
    case GroundKind::kOnPlane:
    case GroundKind::kOnLine:
      break;  // shape_model() knows these
  }
  return {};
}

std::optional<GroundShape> shape_through(GroundKind kind, const std::vector<Eigen::Vector3d>& points) {
  if (static_cast<int>(points.size()) < points_of_shape(kind)) return std::nullopt;
  GroundShape shape;
  if (kind == GroundKind::kAtHeight) return shape;
  for (const Eigen::Vector3d& point : points) shape.origin += point / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points) scatter += (point - shape.origin) * (point - shape.origin).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(scatter);
  const geodetic::ShapeSpread spread{eigen.eigenvalues(), eigen.eigenvectors()};
  if (!(spread.length2[2] > 0) || !std::isfinite(spread.length2[2])) return std::nullopt;
  const auto axes = kind == GroundKind::kOnPlane ? geodetic::OnPlane::axes(spread) : geodetic::OnLine::axes(spread);
  if (!axes) return std::nullopt;
  shape.axes = *axes;
  return shape;
}

GroundModel shape_model(const GroundObservation& observation, const GroundShape& shape, const double* unknowns,
                        const Eigen::Vector3d& point, bool level_at_origin) {
  const geodetic::ShapePoint at{observation, shape, unknowns, point, level_at_origin};
  if (observation.kind == GroundKind::kAtHeight) return geodetic::CommonHeight::model(at);
  return observation.kind == GroundKind::kOnPlane ? geodetic::OnPlane::model(at) : geodetic::OnLine::model(at);
}

double ground_residual(const GroundObservation& observation, const GroundModel& model) {
  const double residual = observation.value - model.computed;
  return observation.is_angle() ? std::remainder(residual, 2 * std::numbers::pi) : residual;
}

}  // namespace collinea
