// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/ellipse.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kHalfTurn = std::numbers::pi;
constexpr double kRoundness = 1e-3;  // relative difference of the semi-axes below which the angle is fixed
constexpr int kIterations = 40;

// The major axis first, its direction within a quarter turn of x.
void normalise(Ellipse& e) {
  if (e.minor_px > e.major_px) {
    std::swap(e.minor_px, e.major_px);
    e.angle_rad += kHalfTurn / 2;
  }
  e.angle_rad = std::remainder(e.angle_rad, kHalfTurn);
}

// Halir and Flusser: minimum of the algebraic distances under 4ac - b^2 = 1, about the mean and scaled.
std::optional<Ellipse> algebraic_ellipse(std::span<const EdgePoint> points) {
  Vector2d middle = Vector2d::Zero();
  for (const EdgePoint& p : points) middle += p.at / double(points.size());
  double scale = 0;
  for (const EdgePoint& p : points) scale += (p.at - middle).norm() / double(points.size());
  if (!(scale > 0)) return std::nullopt;
  Matrix3d s1 = Matrix3d::Zero(), s2 = s1, s3 = s1;
  for (const EdgePoint& p : points) {
    const Vector2d q = (p.at - middle) / scale;
    const Vector3d d1(q.x() * q.x(), q.x() * q.y(), q.y() * q.y()), d2(q.x(), q.y(), 1);
    s1 += d1 * d1.transpose();
    s2 += d1 * d2.transpose();
    s3 += d2 * d2.transpose();
  }
  const Eigen::FullPivLU<Matrix3d> lu(s3);
  if (lu.rcond() < 1e-12) return std::nullopt;
  const Matrix3d t = -lu.solve(s2.transpose()), m = s1 + s2 * t;
  Matrix3d reduced;
  reduced << m.row(2) / 2, -m.row(1), m.row(0) / 2;
  const Eigen::EigenSolver<Matrix3d> eigen(reduced);
  for (int k = 0; k < 3; ++k) {
    const Vector3d a = eigen.eigenvectors().col(k).real();
    if (!(4 * a[0] * a[2] - a[1] * a[1] > 0)) continue;
    const Vector3d b = t * a;
    Matrix3d conic;
    conic << a[0], a[1] / 2, b[0] / 2, a[1] / 2, a[2], b[1] / 2, b[0] / 2, b[1] / 2, b[2];
    auto e = ellipse_of_conic(conic);
    if (!e) continue;
    e->centre = middle + scale * e->centre;
    e->major_px *= scale;
    e->minor_px *= scale;
    return e;
  }
  return std::nullopt;
}

double arc_of(std::span<const EdgePoint> points, const Ellipse& ellipse) {
  std::vector<double> angles;
  for (const EdgePoint& p : points) angles.push_back(ellipse.foot_of(p.at));
  return covered_arc(points, angles);
}

struct Equations {
  MatrixXd design;
  VectorXd misclosure;
  double inwards = 0;
};

Equations equations_of(std::span<const EdgePoint> points, const Ellipse& e, int unknowns) {
  Equations out{MatrixXd(Eigen::Index(points.size()), unknowns), VectorXd(Eigen::Index(points.size()))};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double t = e.foot_of(points[i].at);
    const double c = std::cos(e.angle_rad), s = std::sin(e.angle_rad);
    const Vector2d in_axes = Vector2d(std::cos(t) / e.major_px, std::sin(t) / e.minor_px).normalized();
    const Vector2d outwards(c * in_axes.x() - s * in_axes.y(), s * in_axes.x() + c * in_axes.y());
    out.misclosure[Eigen::Index(i)] = outwards.dot(points[i].at - e.at(t));
    out.design.row(Eigen::Index(i)) = (outwards.transpose() * e.derivatives_at(t)).head(unknowns);
    out.inwards -= outwards.dot(points[i].normal);
  }
  return out;
}

}  // namespace

Vector2d Ellipse::at(double t) const {
  const double u = major_px * std::cos(t), v = minor_px * std::sin(t), c = std::cos(angle_rad), s = std::sin(angle_rad);
  return centre + Vector2d(c * u - s * v, s * u + c * v);
}

Eigen::Matrix<double, 2, 5> Ellipse::derivatives_at(double t) const {
  const double u = std::cos(t), v = std::sin(t), c = std::cos(angle_rad), s = std::sin(angle_rad);
  const Vector2d from_centre = at(t) - centre;
  Eigen::Matrix<double, 2, 5> d;
  d << 1, 0, c * u, -s * v, -from_centre.y(), 0, 1, s * u, c * v, from_centre.x();
  return d;
}

double Ellipse::foot_of(const Vector2d& p) const {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const Vector2d d = p - centre;
  // In the first quadrant of the axes; the root of the derivative of the distance by Newton, kept within it.
  const double u = std::abs(c * d.x() + s * d.y()), v = std::abs(-s * d.x() + c * d.y());
  double low = 0, high = kHalfTurn / 2, t = std::atan2(v * major_px, u * minor_px);
  const double difference = major_px * major_px - minor_px * minor_px;
  for (int i = 0; i < 30; ++i) {
    const double ct = std::cos(t), st = std::sin(t);
    const double slope = major_px * u * st - minor_px * v * ct - difference * st * ct;
    (slope > 0 ? high : low) = t;
    const double curvature = major_px * u * ct + minor_px * v * st - difference * (ct * ct - st * st);
    double next = curvature > 0 ? t - slope / curvature : (low + high) / 2;
    if (!(next >= low && next <= high)) next = (low + high) / 2;
    if (std::abs(next - t) < 1e-14) break;
    t = next;
  }
  if (c * d.x() + s * d.y() < 0) t = kHalfTurn - t;
  return -s * d.x() + c * d.y() < 0 ? -t : t;
}

double Ellipse::distance_px(const Vector2d& p) const {
  const Vector2d d = p - centre;
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const double u = (c * d.x() + s * d.y()) / major_px, v = (-s * d.x() + c * d.y()) / minor_px;
  return std::copysign((p - at(foot_of(p))).norm(), u * u + v * v - 1);
}

std::optional<Ellipse> ellipse_of_conic(const Matrix3d& conic) {
  const Matrix3d symmetric = (conic + conic.transpose()) / 2;
  const Matrix2d quadratic = symmetric.topLeftCorner<2, 2>();
  const double determinant = quadratic.determinant();
  if (!(determinant > 1e-14 * quadratic.squaredNorm())) return std::nullopt;
  Ellipse out;
  out.centre = -quadratic.inverse() * symmetric.topRightCorner<2, 1>();
  const double level = -(symmetric(2, 2) + symmetric.topRightCorner<2, 1>().dot(out.centre));
  const Eigen::SelfAdjointEigenSolver<Matrix2d> axes(level < 0 ? Matrix2d(-quadratic) : quadratic);
  const Vector2d squared = std::abs(level) * axes.eigenvalues().cwiseInverse();
  if (!(squared.minCoeff() > 0) || !squared.allFinite()) return std::nullopt;
  out.major_px = std::sqrt(squared[0]);
  out.minor_px = std::sqrt(squared[1]);
  out.angle_rad = std::atan2(axes.eigenvectors()(1, 0), axes.eigenvectors()(0, 0));
  normalise(out);
  return out;
}

std::optional<EdgeEllipse> fit_ellipse(std::span<const EdgePoint> points, double along_px) {
  if (points.size() < 5) return std::nullopt;
  const auto start = algebraic_ellipse(points);
  if (!start || !(start->minor_px > 1e-3 * start->major_px)) return std::nullopt;
  EdgeEllipse out{.ellipse = *start};
  Ellipse& e = out.ellipse;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const int unknowns = e.major_px - e.minor_px < kRoundness * e.major_px ? 4 : 5;
    const Equations equations = equations_of(points, e, unknowns);
    const auto step = adjust_edge_points(points, along_px, equations.design, equations.misclosure);
    if (!step) return std::nullopt;
    e.centre += step->correction.head<2>();
    e.major_px += step->correction[2];
    e.minor_px += step->correction[3];
    if (unknowns == 5) e.angle_rad += std::clamp(step->correction[4], -0.3, 0.3);
    if (!(e.major_px > 0 && e.minor_px > 0) || !e.centre.allFinite() || e.major_px > 1e3 * start->major_px)
      return std::nullopt;
    if (step->correction.head(4).norm() > 1e-8 * e.major_px) {
      normalise(e);
      continue;
    }
    out.covariance.setZero();
    out.covariance.topLeftCorner(unknowns, unknowns) = step->covariance;
    out.quality = step->quality;
    out.is_bright = equations.inwards > 0;
    out.arc_rad = arc_of(points, e);
    return out;
  }
  return std::nullopt;
}

std::optional<CircleImage> image_of_circle(const Matrix3d& h, const Vector2d& centre, double radius) {
  const Vector3d w = h.row(2);  // the horizon is w . (x, y, 1) = 0
  if (!(w.dot(centre.homogeneous()) > radius * w.head<2>().norm())) return std::nullopt;
  const Eigen::FullPivLU<Matrix3d> lu(h);
  if (!lu.isInvertible()) return std::nullopt;
  Matrix3d circle;
  circle << 1, 0, -centre.x(), 0, 1, -centre.y(), -centre.x(), -centre.y(), centre.squaredNorm() - radius * radius;
  const Matrix3d inverse = lu.inverse();
  const auto ellipse = ellipse_of_conic(inverse.transpose() * circle * inverse);
  if (!ellipse) return std::nullopt;
  return CircleImage{*ellipse, (h * centre.homogeneous()).hnormalized()};
}

}  // namespace collinea
