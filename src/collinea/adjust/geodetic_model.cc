// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/geodetic_model.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace collinea {

GeodeticModel geodetic_model(const GeodeticObservation& observation, const Eigen::Vector3d& from,
                             const Eigen::Vector3d& to, double orientation_rad, const Earth& earth) {
  const Eigen::Vector3d up = geodetic::up_at(from, earth), up_there = geodetic::up_at(to, earth);
  const Eigen::Vector3d line =
      to - from + observation.target_height_m * up_there - observation.instrument_height_m * up;
  const geodetic::Sight sight{observation, from, to, up, up_there, line, orientation_rad, earth};
  GeodeticModel model;  // shape_model() knows the others
  geodetic::visit_kind<geodetic::SightKinds>(observation.kind, [&]<class Kind>() { model = Kind::model(sight); });
  return model;
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
  std::optional<Eigen::Matrix3d> axes;
  geodetic::visit_kind<geodetic::ShapeKinds>(kind, [&]<class Shape>() {
    if constexpr (requires { Shape::axes(spread); }) axes = Shape::axes(spread);
  });
  if (!axes) return std::nullopt;
  shape.axes = *axes;
  return shape;
}

GeodeticModel shape_model(const GeodeticObservation& observation, const GeodeticShape& shape, const double* unknowns,
                          const Eigen::Vector3d& point, const Earth& earth) {
  const geodetic::ShapePoint at{observation, shape, unknowns, point, earth};
  GeodeticModel model;
  geodetic::visit_kind<geodetic::ShapeKinds>(observation.kind, [&]<class Shape>() { model = Shape::model(at); });
  return model;
}

double geodetic_residual(const GeodeticObservation& observation, const GeodeticModel& model) {
  const double residual = observation.value - model.computed;
  return observation.is_angle() ? std::remainder(residual, 2 * std::numbers::pi) : residual;
}

}  // namespace collinea
