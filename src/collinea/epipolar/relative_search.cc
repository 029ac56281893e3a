// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/relative_search.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

constexpr std::size_t kMostPoints = 24;
constexpr int kMostIterations = 30;
constexpr double kLongestStep_rad = 0.6;
constexpr double kSettled = 1e-9;
constexpr double kSame_rad = 1e-4;

struct UnitRays {
  Eigen::Vector3d first, second;
};

std::vector<UnitRays> rays_of(std::span<const PairPoint> points) {
  std::vector<UnitRays> rays;
  const std::size_t count = std::min(points.size(), kMostPoints);
  for (std::size_t k = 0; k < count; ++k) {
    const PairPoint& point = points[k * points.size() / count];
    rays.push_back({point.first.homogeneous().normalized(), point.second.homogeneous().normalized()});
  }
  return rays;
}

// A motion on its way: rotation matrix and unit base in the first camera.
struct Trial {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d base;
  double rms = std::numeric_limits<double>::infinity();
};

// One step of Gauss-Newton; its length, or a negative number where there is none.
double improve(Trial& trial, const std::vector<UnitRays>& rays) {
  const Eigen::Matrix<double, 3, 2> tangents = tangents_of(trial.base);
  Matrix5 normal = Matrix5::Zero();
  Vector5 right = Vector5::Zero();
  double sum = 0;
  for (const UnitRays& ray : rays) {
    const Eigen::Vector3d second = trial.rotation.transpose() * ray.second, across = ray.first.cross(second);
    const double misclosure = trial.base.dot(across);
    Vector5 by;
    by.head<3>() = (trial.rotation * trial.base.cross(ray.first)).cross(ray.second);
    by.tail<2>() = tangents.transpose() * across;
    normal.noalias() += by * by.transpose();
    right.noalias() -= by * misclosure;
    sum += misclosure * misclosure;
  }
  trial.rms = std::sqrt(sum / static_cast<double>(rays.size()));
  const Eigen::LDLT<Matrix5> solver(normal);
  Vector5 step = solver.solve(right);
  if (solver.info() != Eigen::Success || !step.allFinite()) return -1;
  const double length = step.norm();
  if (length > kLongestStep_rad) step *= kLongestStep_rad / length;
  trial.rotation = rotation_by(step.head<3>()).toRotationMatrix() * trial.rotation;
  trial.base = (trial.base + tangents * step.tail<2>()).normalized();
  return length;
}

bool settles(Trial& trial, const std::vector<UnitRays>& rays) {
  for (int i = 0; i < kMostIterations; ++i) {
    const double length = improve(trial, rays);
    if (length < 0) return false;
    if (length < kSettled) return true;
  }
  return false;
}

// The attitudes of the grid: phi, kappa of the first photograph; all but one kappa are left out at the poles.
std::vector<std::array<double, 2>> directions() {
  constexpr double kStep = std::numbers::pi / 4;
  std::vector<std::array<double, 2>> out;
  for (int phi = -2; phi <= 2; ++phi)
    for (int kappa = 0; kappa < (std::abs(phi) == 2 ? 1 : 8); ++kappa) out.push_back({phi * kStep, kappa * kStep});
  return out;
}

bool same(const Trial& a, const Trial& b) {
  return (a.rotation - b.rotation).norm() < kSame_rad && (a.base - b.base).norm() < kSame_rad;
}

Rigid3 motion_of(const Trial& trial) {
  Rigid3 motion;
  motion.rotation = Eigen::Quaterniond(trial.rotation).normalized();
  motion.translation = -(motion.rotation * trial.base);
  return motion;
}

}  // namespace

ParallaxEquation parallax_equation(const PairPoint& point) {
  const double y1 = -point.first.y(), y2 = -point.second.y(), y = (y1 + y2) / 2;  // y up
  const double x2 = point.second.x(), px = x2 - point.first.x();
  return {(Vector5() << px, px * y, -(1 + y * y), x2 * y, -x2).finished(), y2 - y1};
}

std::optional<LinearOrientation> linear_orientation(std::span<const PairPoint> points) {
  if (points.size() < 5) return std::nullopt;
  Eigen::Matrix<double, Eigen::Dynamic, 5> design(points.size(), 5);
  Eigen::VectorXd parallax(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PairPoint& point = points[i];
    const ParallaxEquation equation = parallax_equation(point);
    const double weight = 1 / std::hypot(point.sigma_first, point.sigma_second);
    const auto row = static_cast<Eigen::Index>(i);
    design.row(row) = weight * equation.coefficients.transpose();
    parallax(row) = weight * equation.parallax;
  }
  const Eigen::ColPivHouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, 5>> solver(design);
  if (solver.rank() < 5) return std::nullopt;
  const Vector5 x = solver.solve(parallax);
  if (!x.allFinite()) return std::nullopt;
  LinearOrientation out{DependentElements{1, x(0), x(1), x(2), x(3), x(4)}, Matrix5::Zero(), {}};
  out.covariance = (design.transpose() * design).ldlt().solve(Matrix5::Identity());
  const Eigen::VectorXd left = parallax - design * x;
  for (std::size_t i = 0; i < points.size(); ++i)
    out.parallaxes.push_back(left(static_cast<Eigen::Index>(i)) *
                             std::hypot(points[i].sigma_first, points[i].sigma_second));
  out.redundancy = static_cast<int>(points.size()) - 5;
  if (out.redundancy > 0) out.sigma0 = std::sqrt(left.squaredNorm() / out.redundancy);
  return out;
}

std::optional<DependentElements> linear_parallax(std::span<const PairPoint> points) {
  const auto found = linear_orientation(points);
  if (!found) return std::nullopt;
  return found->elements;
}

std::optional<RelativeSearch> search_relative(std::span<const PairPoint> points) {
  if (points.size() < 5) return std::nullopt;
  const std::vector<UnitRays> rays = rays_of(points);
  RelativeSearch out;
  std::vector<Trial> found;
  const auto grid = directions();
  for (const auto& [phi1, kappa1] : grid)
    for (int omega2 = 0; omega2 < 8; ++omega2)
      for (const auto& [phi2, kappa2] : grid) {
        ++out.starts;
        const Rigid3 start =
            collinea::motion_of(SymmetricElements{phi1, kappa1, omega2 * std::numbers::pi / 4, phi2, kappa2});
        Trial trial{start.rotation.toRotationMatrix(), base_in_first(start)};
        if (!settles(trial, rays)) continue;
        ++out.converged;
        if (std::none_of(found.begin(), found.end(), [&](const Trial& other) { return same(trial, other); }))
          found.push_back(trial);
      }
  if (found.empty()) return std::nullopt;
  std::stable_sort(found.begin(), found.end(), [](const Trial& a, const Trial& b) { return a.rms < b.rms; });
  out.rms = found.front().rms;
  for (const Trial& trial : found)
    if (trial.rms < 1.001 * out.rms + 1e-9) out.distinct.push_back(motion_of(trial));
  return out;
}

}  // namespace collinea
