// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/pair_shape.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/epipolar/spatial_parallax.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kCriticalRoughness = 0.01, kNearRoughness = 0.05;  // of the distance
constexpr double kCriticalEpsilon = 1e-9;
constexpr double kFlatRoughness = 0.02;
constexpr double kNarrowBreadth_rad = 0.06;
constexpr double kShortBase_rad = 2 * std::numbers::pi / 180;
constexpr double kBeyondNoise = 3;

// Model points that lie in front of both cameras, in the first camera, in bases.
struct Model {
  std::vector<Eigen::Vector3d> points;
  std::vector<double> angles, sigmas;  // where rays meet; of the depths by the measurements alone
};

Model model_of(const Rigid3& motion, std::span<const PairPoint> pairs) {
  Model model;
  for (const PairPoint& pair : pairs) {
    const auto meeting = spatial_parallax(motion, pair.first, pair.second);
    if (!meeting || meeting->along_first <= 0 || meeting->along_second <= 0) continue;
    model.points.push_back(meeting->point_in_first);
    const Eigen::Vector3d from_second = meeting->point_in_first - base_in_first(motion);
    const double angle =
        std::atan2(meeting->point_in_first.cross(from_second).norm(), meeting->point_in_first.dot(from_second));
    model.angles.push_back(angle);
    model.sigmas.push_back(std::hypot(pair.sigma_first, pair.sigma_second) * meeting->point_in_first.norm() /
                           std::max(angle, 1e-9));
  }
  return model;
}

// Axes across the base, the second towards the middle of the points.
Eigen::Matrix<double, 3, 2> axes_across(const Eigen::Vector3d& base, const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) mean += point;
  Eigen::Vector3d towards = mean - base * base.dot(mean);
  towards = towards.norm() > 1e-9 * mean.norm() ? towards.normalized() : Eigen::Vector3d(tangents_of(base).col(0));
  Eigen::Matrix<double, 3, 2> axes;
  axes << towards.cross(base), towards;
  return axes;
}

// The circle through the origin: y^2 + z^2 = 2 (a y + b z), by algebraic least squares, refined on true distances.
std::optional<CriticalCylinder> cylinder_through(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) {
    normal += 4 * p * p.transpose();
    right += 2 * p * p.squaredNorm();
  }
  if (!(normal.determinant() > 1e-9 * normal.trace() * normal.trace())) return std::nullopt;
  CriticalCylinder out{normal.inverse() * right};
  for (int i = 0; i < 10; ++i) {  // Gauss-Newton on |p - c| - |c|
    normal.setZero();
    right.setZero();
    for (const Eigen::Vector2d& p : points) {
      const Eigen::Vector2d to = out.centre - p;
      const Eigen::Vector2d by = to.normalized() - out.centre.normalized();
      normal += by * by.transpose();
      right -= by * (to.norm() - out.centre.norm());
    }
    if (!(normal.determinant() > 1e-12 * normal.trace() * normal.trace())) break;
    const Eigen::Vector2d step = normal.inverse() * right;
    if (!(step.norm() < 0.5 * out.centre.norm())) break;
    out.centre += step;
  }
  out.radius = out.centre.norm();
  double sum = 0;
  for (const Eigen::Vector2d& p : points) sum += std::pow((p - out.centre).norm() - out.radius, 2);
  out.roughness = std::sqrt(sum / static_cast<double>(points.size()));
  return out;
}

// The plane that fits points best, through their middle, and their RMS distance from it.
void set_plane(const std::vector<Eigen::Vector3d>& points, PairShape& shape) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(scatter);
  shape.plane_roughness = std::sqrt(std::max(0.0, solver.eigenvalues()(0)) / static_cast<double>(points.size()));
  shape.plane_normal = solver.eigenvectors().col(0);
  shape.plane_middle = mean;
}

// The plane through the base that fits them best.
void set_base_plane(const std::vector<Eigen::Vector2d>& across, PairShape& shape) {
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& p : across) scatter += p * p.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(scatter);
  shape.base_plane_roughness = std::sqrt(std::max(0.0, solver.eigenvalues()(0)) / static_cast<double>(across.size()));
  shape.base_plane_direction = solver.eigenvectors().col(1);
}

// Conditioning of the elements of a dependent pair; of the changes themselves where these elements are singular.
void set_conditioning(const Rigid3& motion, const Matrix5& of_change, PairShape& shape) {
  Matrix5 normal = of_change;
  if (const auto elements = dependent_elements(motion); elements && std::abs(base_in_first(motion).x()) > 0.2) {
    const Matrix5 by = dependent_by_change(motion).inverse();
    normal = by.transpose() * of_change * by;
  } else {
    shape.of_elements = false;
  }
  const auto ratio = [](const Eigen::SelfAdjointEigenSolver<Matrix5>& solver) {
    return std::max(0.0, solver.eigenvalues()(0)) / solver.eigenvalues()(4);
  };
  shape.epsilon_raw = ratio(Eigen::SelfAdjointEigenSolver<Matrix5>(normal));
  const Vector5 scale = normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix5> scaled(Matrix5(scale.asDiagonal() * normal * scale.asDiagonal()));
  shape.epsilon = ratio(scaled);
  Vector5 null = scaled.eigenvectors().col(0);
  Eigen::Index largest = 0;
  null.cwiseAbs().maxCoeff(&largest);
  shape.null_vector = null / null(largest);
  double worst = 1;
  for (int i = 0; i < 5; ++i) {
    double inverse = 0;
    for (int k = 0; k < 5; ++k)
      inverse += std::pow(scaled.eigenvectors()(i, k), 2) / std::max(scaled.eigenvalues()(k), 1e-16);
    worst = std::max(worst, inverse);
  }
  shape.inflation = std::sqrt(worst);
}

void set_weaknesses(PairShape& shape) {
  std::vector<PairWeakness>& found = shape.weaknesses;
  if (shape.base_plane_roughness < kCriticalRoughness * shape.distance)
    found.push_back(PairWeakness::kBasePlane);
  else if (shape.breadth < kNarrowBreadth_rad)
    found.push_back(PairWeakness::kNarrow);
  else if (shape.epsilon < kCriticalEpsilon ||
           (shape.cylinder && shape.cylinder->roughness < kCriticalRoughness * shape.distance))
    found.push_back(PairWeakness::kCylinder);
  else if (shape.cylinder && shape.cylinder->roughness < kNearRoughness * shape.distance)
    found.push_back(PairWeakness::kNearCylinder);
  if (shape.plane_roughness <
      std::max(1e-6 * shape.distance, std::min(kFlatRoughness * shape.distance, kBeyondNoise * shape.plane_sigma)))
    found.push_back(PairWeakness::kPlane);
  else if (shape.plane_roughness < kNearRoughness * shape.distance)
    found.push_back(PairWeakness::kNearPlane);
  if (shape.median_angle_rad < kShortBase_rad) found.push_back(PairWeakness::kShortBase);
}

}  // namespace

Matrix5 normal_of(const Rigid3& motion, std::span<const PairPoint> points) {
  const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
  const Eigen::Vector3d base = base_in_first(motion);
  const Eigen::Matrix<double, 3, 2> tangents = tangents_of(base);
  Matrix5 normal = Matrix5::Zero();
  for (const PairPoint& point : points) {
    const Eigen::Vector3d first = point.first.homogeneous(), second = point.second.homogeneous();
    const Eigen::Vector3d turned = rotation.transpose() * second, across = rotation * base.cross(first);
    Vector5 by;
    by << across.cross(second), tangents.transpose() * first.cross(turned);
    const double variance = point.sigma_first * point.sigma_first * turned.cross(base).head<2>().squaredNorm() +
                            point.sigma_second * point.sigma_second * across.head<2>().squaredNorm();
    if (variance > 0) normal += by * by.transpose() / variance;
  }
  return normal;
}

std::optional<PairShape> pair_shape(const Rigid3& second_from_first, std::span<const PairPoint> points,
                                    const Matrix5& normal) {
  Model model = model_of(second_from_first, points);
  if (model.points.size() < 5) return std::nullopt;
  PairShape shape;
  shape.points = static_cast<int>(model.points.size());
  const auto count = static_cast<double>(shape.points);
  const Eigen::Vector3d base = base_in_first(second_from_first);
  shape.across_in_first = axes_across(base, model.points);
  std::vector<Eigen::Vector2d> across;
  double least = model.points[0].dot(base), most = least, mean = 0, squares = 0, noise = 0;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const Eigen::Vector3d& point = model.points[i];
    across.emplace_back(shape.across_in_first.transpose() * point);
    shape.distance += across.back().norm() / count;
    least = std::min(least, point.dot(base));
    most = std::max(most, point.dot(base));
    const double direction = std::atan2(across.back().x(), across.back().y());
    mean += direction / count;
    squares += direction * direction / count;
    noise += model.sigmas[i] * model.sigmas[i] / count;
  }
  shape.width = most - least;
  shape.breadth = std::sqrt(std::max(0.0, squares - mean * mean));
  shape.median_angle_rad = median(std::move(model.angles));
  shape.cylinder = cylinder_through(across);
  set_plane(model.points, shape);
  shape.plane_sigma = std::sqrt(noise);
  set_base_plane(across, shape);
  set_conditioning(second_from_first, normal, shape);
  set_weaknesses(shape);
  return shape;
}

}  // namespace collinea
