// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/edge_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "collinea/feature/edge_correlation.h"
#include "collinea/math/fisher.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kScaleLevel = 0.001;
constexpr int kIterations = 30;
constexpr double kGapPx = 3;  // between neighbours on a curve that is covered

// A' P C P A, and the sum of squared correlations.
struct Spread {
  MatrixXd moments;
  double squared_correlations = 0;
};

Spread spread_of(std::span<const EdgePoint> points, double along_px, const MatrixXd& weighted) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  Vector2d low = points[0].at, high = low;
  for (const EdgePoint& p : points) {
    low = low.cwiseMin(p.at);
    high = high.cwiseMax(p.at);
  }
  const int axis = high.x() - low.x() > high.y() - low.y() ? 0 : 1;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return points[a].at[axis] < points[b].at[axis]; });
  const double reach = 5 * along_px;
  Spread out{MatrixXd::Zero(weighted.cols(), weighted.cols())};
  for (std::size_t i = 0; i < order.size(); ++i) {
    const EdgePoint& p = points[order[i]];
    const auto row = weighted.row(Eigen::Index(order[i]));
    out.moments += row.transpose() * row;
    out.squared_correlations += 1;
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      const EdgePoint& q = points[order[j]];
      if (q.at[axis] - p.at[axis] > reach) break;
      const double correlation = edge_correlation(p, q, along_px);
      const auto other = weighted.row(Eigen::Index(order[j]));
      out.moments += correlation * (row.transpose() * other + other.transpose() * row);
      out.squared_correlations += 2 * correlation * correlation;
    }
  }
  return out;
}

}  // namespace

std::optional<EdgeStep> adjust_edge_points(std::span<const EdgePoint> points, double along_px, const MatrixXd& design,
                                           const VectorXd& misclosure) {
  const auto n = Eigen::Index(points.size());
  if (n < design.cols()) return std::nullopt;
  MatrixXd a = design;
  VectorXd l = misclosure;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double sigma = std::max(points[std::size_t(i)].sigma_px, 1e-4);
    a.row(i) /= sigma;
    l[i] /= sigma;
  }
  const VectorXd scale = a.colwise().norm().cwiseMax(1e-300);  // unknowns of different units
  const MatrixXd scaled = a * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled.transpose() * scaled);
  if (!(eigen.eigenvalues()[0] > 1e-12)) return std::nullopt;
  const MatrixXd inverse = scale.cwiseInverse().asDiagonal() * eigen.eigenvectors() *
                           eigen.eigenvalues().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose() *
                           scale.cwiseInverse().asDiagonal();
  EdgeStep out;
  out.correction = inverse * (a.transpose() * l);
  const VectorXd v = l - a * out.correction;
  const Spread spread = spread_of(points, std::max(along_px, 1e-3), a);
  out.covariance = inverse * spread.moments * inverse;
  EdgeFitQuality& q = out.quality;
  q.redundancy = std::max(0.0, double(n) - (inverse * spread.moments).trace());
  q.rms_px = std::sqrt((misclosure - design * out.correction).squaredNorm() / double(n));
  if (n > design.cols() && q.redundancy > 0.5) {
    q.sigma0 = std::sqrt(v.squaredNorm() / q.redundancy);
    const double freedom = std::max(1.0, q.redundancy * double(n) / spread.squared_correlations);
    q.is_scaled = q.sigma0 > 1 &&
                  fisher_tail(q.sigma0 * q.sigma0, freedom, std::numeric_limits<double>::infinity()) < kScaleLevel;
    if (q.is_scaled) out.covariance *= q.sigma0 * q.sigma0;
  }
  return out;
}

double covered_arc(std::span<const EdgePoint> points, const std::vector<double>& angles_rad) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto angle = [&](std::size_t i) { return std::remainder(angles_rad[i], 2 * std::numbers::pi); };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return angle(a) < angle(b); });
  double covered = 2 * std::numbers::pi;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t a = order[k], b = order[(k + 1) % order.size()];
    double gap = angle(b) - angle(a);
    if (k + 1 == order.size()) gap += 2 * std::numbers::pi;
    if ((points[b].at - points[a].at).norm() > kGapPx || order.size() == 1) covered -= gap;
  }
  return std::max(0.0, covered);
}

std::optional<EdgeLine> fit_line(std::span<const EdgePoint> points, double along_px) {
  if (points.size() < 2) return std::nullopt;
  Vector2d middle = Vector2d::Zero(), brighter = Vector2d::Zero();
  for (const EdgePoint& p : points) {
    middle += p.at / double(points.size());
    brighter += p.normal;
  }
  Matrix2d scatter = Matrix2d::Zero();
  for (const EdgePoint& p : points) scatter += (p.at - middle) * (p.at - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix2d> axes(scatter);
  if (!(axes.eigenvalues()[1] > 1e-12)) return std::nullopt;
  Vector2d normal = axes.eigenvectors().col(0);
  if (normal.dot(brighter) < 0) normal = -normal;
  double theta = std::atan2(normal.y(), normal.x()), r = 0;  // r from the middle
  std::optional<EdgeStep> step;
  MatrixXd design(Eigen::Index(points.size()), 2);
  VectorXd misclosure(design.rows());
  for (int iteration = 0; iteration < 5; ++iteration) {
    const Vector2d n(std::cos(theta), std::sin(theta)), along(-n.y(), n.x());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d p = points[i].at - middle;
      misclosure[Eigen::Index(i)] = n.dot(p) - r;
      design.row(Eigen::Index(i)) << -along.dot(p), 1;
    }
    step = adjust_edge_points(points, along_px, design, misclosure);
    if (!step) return std::nullopt;
    theta += step->correction[0];
    r += step->correction[1];
    if (std::abs(step->correction[0]) < 1e-12) break;
  }
  EdgeLine line{.theta_rad = std::remainder(theta, 2 * std::numbers::pi), .quality = step->quality};
  const Vector2d n = line.normal(), along(-n.y(), n.x());
  line.r_px = r + n.dot(middle);
  Matrix2d to_corner;  // r counts from the corner of the image
  to_corner << 1, 0, along.dot(middle), 1;
  line.covariance = to_corner * step->covariance * to_corner.transpose();
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (const EdgePoint& p : points) {
    first = std::min(first, along.dot(p.at));
    last = std::max(last, along.dot(p.at));
  }
  line.from = line.r_px * n + first * along;
  line.to = line.r_px * n + last * along;
  return line;
}

namespace {

// Algebraic start: x^2 + y^2 = 2 a x + 2 b y + c, about the mean.
std::optional<EdgeCircle> algebraic_circle(std::span<const EdgePoint> points) {
  Vector2d middle = Vector2d::Zero();
  for (const EdgePoint& p : points) middle += p.at / double(points.size());
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const EdgePoint& p : points) {
    const Vector2d q = p.at - middle;
    const Eigen::Vector3d row(2 * q.x(), 2 * q.y(), 1);
    normals += row * row.transpose();
    right += row * q.squaredNorm();
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(normals);
  if (lu.rank() < 3 || lu.rcond() < 1e-12) return std::nullopt;
  const Eigen::Vector3d solution = lu.solve(right);
  const double squared = solution[2] + solution.head<2>().squaredNorm();
  if (!(squared > 0)) return std::nullopt;
  return EdgeCircle{.centre = middle + solution.head<2>(), .radius_px = std::sqrt(squared)};
}

double arc_of(std::span<const EdgePoint> points, const Vector2d& centre) {
  std::vector<double> angles;
  for (const EdgePoint& p : points) angles.push_back(std::atan2(p.at.y() - centre.y(), p.at.x() - centre.x()));
  return covered_arc(points, angles);
}

}  // namespace

std::optional<EdgeCircle> fit_circle(std::span<const EdgePoint> points, double along_px) {
  if (points.size() < 3) return std::nullopt;
  std::optional<EdgeCircle> circle = algebraic_circle(points);
  if (!circle) return std::nullopt;
  MatrixXd design(Eigen::Index(points.size()), 3);
  VectorXd misclosure(design.rows());
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    double inwards = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d d = points[i].at - circle->centre;
      const double distance = std::max(d.norm(), 1e-9);
      misclosure[Eigen::Index(i)] = distance - circle->radius_px;
      design.row(Eigen::Index(i)) << d.x() / distance, d.y() / distance, 1;
      inwards -= points[i].normal.dot(d) / distance;
    }
    const auto step = adjust_edge_points(points, along_px, design, misclosure);
    if (!step) return std::nullopt;
    circle->centre += step->correction.head<2>();
    circle->radius_px += step->correction[2];
    if (!(circle->radius_px > 0) || !circle->centre.allFinite()) return std::nullopt;
    if (step->correction.norm() > 1e-9 * circle->radius_px) continue;
    circle->covariance = step->covariance;
    circle->quality = step->quality;
    circle->is_bright = inwards > 0;
    circle->arc_rad = arc_of(points, circle->centre);
    return circle;
  }
  return std::nullopt;
}

}  // namespace collinea
