// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/line_intersection.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kLeastAngleSigmas = 5;  // within which the equations are not those of their linear parts
constexpr int kMostIterations = 30;

Vector3d line_vector(const ImageLine& line) { return {std::cos(line.theta_rad), std::sin(line.theta_rad), -line.r}; }

Vector3d normal_in_world(const ImageLine& line) {
  return (line.cam_from_world.rotation.conjugate() * line_vector(line)).normalized();
}

// How well the plane's normal is known along a unit vector across it.
double normal_sigma(const ImageLine& line, const Vector3d& along_in_world) {
  const Vector3d e = line.cam_from_world.rotation * along_in_world;
  const Vector2d by(-std::sin(line.theta_rad) * e.x() + std::cos(line.theta_rad) * e.y(), -e.z());
  return std::sqrt(std::max(by.dot(line.covariance * by), 0.0)) / line_vector(line).norm();
}

struct PlaneAngle {
  std::size_t first = 0, second = 0;
  double angle = 0, sigma = 0;
};

// The two planes that meet under the largest angle.
PlaneAngle largest_angle(std::span<const ImageLine> lines) {
  PlaneAngle best;
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (std::size_t k = i + 1; k < lines.size(); ++k) {
      const Vector3d a = normal_in_world(lines[i]), b = normal_in_world(lines[k]);
      const double sine = a.cross(b).norm();
      if (!(sine > std::sin(best.angle))) continue;
      const double cosine = a.dot(b);
      best = {
          i, k, std::asin(std::min(sine, 1.0)),
          std::hypot(normal_sigma(lines[i], (b - cosine * a) / sine), normal_sigma(lines[k], (a - cosine * b) / sine))};
    }
  return best;
}

Eigen::Matrix<double, 3, 2> across_of(const Vector3d& direction) {
  Eigen::Matrix<double, 3, 2> out;
  out.col(0) = direction.unitOrthogonal();
  out.col(1) = direction.cross(out.col(0));
  return out;
}

struct Equations {
  Eigen::Matrix<double, 2, 4> by_line;
  Vector2d misfit;
  Matrix2d weight;
};

std::optional<Equations> equations_of(const ImageLine& line, const SpaceLine& at) {
  const Matrix3d rotation = line.cam_from_world.rotation.toRotationMatrix();
  const Vector3d arm = at.point - centre_of(line.cam_from_world), normal = arm.cross(at.direction);
  const Vector3d l = rotation * normal, measured = line_vector(line);
  const double sign = l.head<2>().dot(measured.head<2>()) < 0 ? -1 : 1;
  const double a = sign * l.x(), b = sign * l.y(), c = sign * l.z(), h = std::hypot(a, b);
  if (!(h > 0)) return std::nullopt;
  Eigen::Matrix<double, 2, 3> by_normal;
  by_normal << -b / (h * h), a / (h * h), 0, c * a / (h * h * h), c * b / (h * h * h), -1 / h;
  by_normal = sign * by_normal * rotation;
  Equations e;
  e.by_line << -by_normal * skew(at.direction) * at.across, by_normal * skew(arm) * at.across;
  e.misfit = {std::remainder(line.theta_rad - std::atan2(b, a), 2 * std::numbers::pi), line.r + c / h};
  Eigen::Matrix<double, 2, 6> by_pose;
  by_pose << by_normal * skew(normal), by_normal * skew(at.direction);
  const Eigen::LLT<Matrix2d> factor(line.covariance + by_pose * line.pose_covariance * by_pose.transpose());
  if (factor.info() != Eigen::Success) return std::nullopt;
  e.weight = factor.solve(Matrix2d::Identity());
  return e;
}

void move(SpaceLine& line, const Vector4d& step) {
  line.point += line.across * step.head<2>();
  line.direction = (line.direction + line.across * step.tail<2>()).normalized();
  line.across = across_of(line.direction);
}

// Where two planes meet, near to the ray through the middle of the first image's piece.
SpaceLine start_of(std::span<const ImageLine> lines, const PlaneAngle& angle) {
  const ImageLine &one = lines[angle.first], &two = lines[angle.second];
  const Vector3d n1 = normal_in_world(one), n2 = normal_in_world(two);
  SpaceLine line;
  line.direction = n1.cross(n2).normalized();
  line.across = across_of(line.direction);
  Matrix3d planes;
  planes << n1.transpose(), n2.transpose(), line.direction.transpose();
  const Vector3d c1 = centre_of(one.cam_from_world), c2 = centre_of(two.cam_from_world);
  line.point = planes.inverse() * Vector3d(n1.dot(c1), n2.dot(c2), line.direction.dot(c1));
  line.point = line.at(line.nearest_to(lines[0].cam_from_world, lines[0].middle));
  return line;
}

}  // namespace

ImageLine image_line(const Rigid3& cam_from_world, double focal_px, const Vector2d& principal_point_px,
                     const PixelLine& line) {
  const Vector2d normal(std::cos(line.theta_rad), std::sin(line.theta_rad)), along(-normal.y(), normal.x());
  Matrix2d by;
  by << 1, 0, -along.dot(principal_point_px) / focal_px, 1 / focal_px;
  return {.cam_from_world = cam_from_world,
          .theta_rad = line.theta_rad,
          .r = (line.r_px - normal.dot(principal_point_px)) / focal_px,
          .covariance = by * line.covariance * by.transpose(),
          .middle = (line.middle_px - principal_point_px) / focal_px};
}

Matrix2d SpaceLine::covariance_at(double along_m) const {
  Eigen::Matrix<double, 2, 4> by;
  by << Matrix2d::Identity(), along_m * Matrix2d::Identity();
  return by * covariance * by.transpose();
}

double SpaceLine::nearest_to(const Rigid3& cam_from_world, const Vector2d& xy) const {
  const Vector3d ray = (cam_from_world.rotation.conjugate() * xy.homogeneous()).normalized();
  const Vector3d arm = centre_of(cam_from_world) - point;
  const double cosine = ray.dot(direction);
  return (arm.dot(direction) - cosine * arm.dot(ray)) / (1 - cosine * cosine);
}

std::optional<SpaceLine> intersect_lines(std::span<const ImageLine> lines, double least_angle_rad) {
  if (lines.size() < 2) return std::nullopt;
  const PlaneAngle angle = largest_angle(lines);
  if (!(angle.angle >= least_angle_rad) || !(angle.angle >= kLeastAngleSigmas * angle.sigma)) return std::nullopt;
  SpaceLine line = start_of(lines, angle);
  line.angle_rad = angle.angle;
  line.angle_sigma_rad = angle.sigma;
  bool has_converged = false;
  for (int iteration = 0; iteration < kMostIterations && !has_converged; ++iteration) {
    Matrix4d normal = Matrix4d::Zero();
    Vector4d right = Vector4d::Zero();
    line.squares = 0;
    for (const ImageLine& one : lines) {
      const auto e = equations_of(one, line);
      if (!e) return std::nullopt;
      normal += e->by_line.transpose() * e->weight * e->by_line;
      right += e->by_line.transpose() * e->weight * e->misfit;
      line.squares += e->misfit.dot(e->weight * e->misfit);
    }
    const Eigen::LDLT<Matrix4d> factor(normal);
    if (!(factor.vectorD().minCoeff() > 0)) return std::nullopt;
    line.covariance = factor.solve(Matrix4d::Identity());
    const Vector4d step = factor.solve(right);
    if (!step.allFinite()) return std::nullopt;
    has_converged = step.dot(normal * step) < 1e-16 * std::max(1.0, line.squares);
    if (!has_converged) move(line, step);
  }
  if (!has_converged) return std::nullopt;
  for (const ImageLine& one : lines)
    if (!((one.cam_from_world * line.at(line.nearest_to(one.cam_from_world, one.middle))).z() > 0)) return std::nullopt;
  line.redundancy = 2 * int(lines.size()) - 4;
  if (line.redundancy > 0) line.sigma0 = std::sqrt(line.squares / line.redundancy);
  return line;
}

}  // namespace collinea
