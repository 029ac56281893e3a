// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/ground_model.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr double kEarthRadius_m = 6371000;
constexpr double kRefraction = 0.13;  // radius of the Earth over that of the line of sight (Gauss)

// From the middle of the Earth.
Eigen::Vector3d from_middle(const Eigen::Vector3d& point) { return {point.x(), point.y(), point.z() + kEarthRadius_m}; }

// Its change along the line of sight is below 1e-6 of the effect itself: the derivatives take it as constant.
Eigen::Vector3d up_at(const Eigen::Vector3d& point, bool level_at_origin) {
  return level_at_origin ? from_middle(point).normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
}

// |P| - R without the loss of digits of a difference of two large numbers.
double height_of(const Eigen::Vector3d& point, bool level_at_origin) {
  if (!level_at_origin) return point.z();
  const double radius = from_middle(point).norm();
  return (point.squaredNorm() + 2 * kEarthRadius_m * point.z()) / (radius + kEarthRadius_m);
}

void by_line(GroundModel& model, const Eigen::Vector3d& derivative) {
  model.by_to = derivative;
  model.by_from = -derivative;
}

}  // namespace

GroundModel ground_model(const GroundObservation& observation, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                         double orientation_rad, bool level_at_origin) {
  const Eigen::Vector3d up = up_at(from, level_at_origin), up_there = up_at(to, level_at_origin);
  const Eigen::Vector3d line =
      to - from + observation.target_height_m * up_there - observation.instrument_height_m * up;
  GroundModel model;
  switch (observation.kind) {
    case GroundKind::kDistance:
      model.computed = line.norm();
      if (model.computed > 0) by_line(model, line / model.computed);
      break;
    case GroundKind::kHeightDifference:
      model.computed = height_of(to, level_at_origin) - height_of(from, level_at_origin);
      model.by_to = up_there;
      model.by_from = -up;
      break;
    case GroundKind::kDirection: {
      const Eigen::Vector3d east = Eigen::Vector3d::UnitY().cross(up).normalized(), north = up.cross(east);
      const double e = line.dot(east), n = line.dot(north), squared = e * e + n * n;
      model.computed = std::atan2(e, n) - orientation_rad;
      model.by_extra[0] = -1;
      model.extras = 1;
      if (squared > 0) by_line(model, (n * east - e * north) / squared);
      break;
    }
    case GroundKind::kZenithAngle: {
      const double height = line.dot(up);
      const Eigen::Vector3d level = line - height * up;
      const double across = level.norm(), squared = line.squaredNorm();
      model.computed = std::atan2(across, height);
      if (level_at_origin) model.computed -= kRefraction * across / (2 * kEarthRadius_m);
      if (across > 0) by_line(model, (height / across * level - across * up) / squared);
      break;
    }
    case GroundKind::kAtHeight:
    case GroundKind::kOnPlane:
    case GroundKind::kOnLine:
      break;  // shape_model() knows these
  }
  return model;
}

std::optional<GroundShape> shape_through(GroundKind kind, const std::vector<Eigen::Vector3d>& points) {
  if (static_cast<int>(points.size()) < points_of_shape(kind)) return std::nullopt;
  GroundShape shape;
  if (kind == GroundKind::kAtHeight) return shape;
  for (const Eigen::Vector3d& point : points) shape.origin += point / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& point : points) spread += (point - shape.origin) * (point - shape.origin).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
  const Eigen::Vector3d length2 = eigen.eigenvalues();
  Eigen::Vector3d along = eigen.eigenvectors().col(2);
  if (along.z() < 0) along = -along;
  if (!(length2[2] > 0) || !std::isfinite(length2[2])) return std::nullopt;
  if (kind == GroundKind::kOnPlane) {
    constexpr double kNarrow = 1e-3;
    if (!(length2[1] > kNarrow * kNarrow * length2[2])) return std::nullopt;
    shape.axes.col(2) = eigen.eigenvectors().col(0);
    shape.axes.col(0) = along;
    shape.axes.col(1) = shape.axes.col(2).cross(along);
    return shape;
  }
  constexpr double kPlumb = 0.999;  // 2.6 degrees off: what is sideways is east
  const Eigen::Vector3d sideways =
      (along.z() > kPlumb ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ()).cross(along);
  shape.axes.col(0) = sideways.normalized();
  shape.axes.col(1) = along.cross(shape.axes.col(0));
  shape.axes.col(2) = along;
  return shape;
}

GroundModel shape_model(const GroundObservation& observation, const GroundShape& shape, const double* unknowns,
                        const Eigen::Vector3d& point, bool level_at_origin) {
  GroundModel model;
  const Eigen::Vector3d local = shape.axes.transpose() * (point - shape.origin);
  switch (observation.kind) {
    case GroundKind::kAtHeight:
      model.computed = height_of(point, level_at_origin) - unknowns[0];
      model.by_from = up_at(point, level_at_origin);
      model.by_extra[0] = -1;
      model.extras = 1;
      break;
    case GroundKind::kOnPlane: {
      const Eigen::Vector3d across(unknowns[1], unknowns[2], 1);
      const double length = across.norm(), height = across.dot(local) / length;
      model.computed = height - unknowns[0];
      model.by_from = shape.axes * (across / length);
      model.by_extra = {-1, (local.x() - height * unknowns[1] / length) / length,
                        (local.y() - height * unknowns[2] / length) / length};
      model.extras = 3;
      break;
    }
    default:
      model.computed = local[observation.axis] - unknowns[0] - unknowns[1] * local.z();
      model.by_from = shape.axes.col(observation.axis) - unknowns[1] * shape.axes.col(2);
      model.by_extra = {-1, -local.z(), 0};
      model.extras = 2;
      break;
  }
  return model;
}

double ground_residual(const GroundObservation& observation, const GroundModel& model) {
  const double residual = observation.value - model.computed;
  return observation.is_angle() ? std::remainder(residual, 2 * std::numbers::pi) : residual;
}

}  // namespace collinea
