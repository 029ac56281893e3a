// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/p3p.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "collinea/math/polynomial.h"

namespace collinea {
namespace {

// A symmetric 3x3 matrix: a conic of the homogeneous distances.
struct Conic {
  double c00, c01, c02, c11, c12, c22;

  [[nodiscard]] double at(const Eigen::Vector3d& a, const Eigen::Vector3d& b) const {
    return a.x() * (c00 * b.x() + c01 * b.y() + c02 * b.z()) + a.y() * (c01 * b.x() + c11 * b.y() + c12 * b.z()) +
           a.z() * (c02 * b.x() + c12 * b.y() + c22 * b.z());
  }
};

Conic combined(const Conic& a, double factor, const Conic& b) {
  return {a.c00 + factor * b.c00, a.c01 + factor * b.c01, a.c02 + factor * b.c02,
          a.c11 + factor * b.c11, a.c12 + factor * b.c12, a.c22 + factor * b.c22};
}

Conic adjugate(const Conic& m) {
  return {m.c11 * m.c22 - m.c12 * m.c12, m.c02 * m.c12 - m.c01 * m.c22, m.c01 * m.c12 - m.c02 * m.c11,
          m.c00 * m.c22 - m.c02 * m.c02, m.c01 * m.c02 - m.c00 * m.c12, m.c00 * m.c11 - m.c01 * m.c01};
}

double inner(const Conic& a, const Conic& b) {  // trace(A B)
  return a.c00 * b.c00 + a.c11 * b.c11 + a.c22 * b.c22 + 2 * (a.c01 * b.c01 + a.c02 * b.c02 + a.c12 * b.c12);
}

// The root of det(a + x b) where the determinant changes fastest: the best determined member of the pencil.
std::optional<double> best_root(const Conic& a, const Conic& b) {
  const Conic adjugate_a = adjugate(a), adjugate_b = adjugate(b);
  const std::array<double, 4> c = {inner(adjugate_a, a) / 3, inner(adjugate_a, b), inner(a, adjugate_b),
                                   inner(adjugate_b, b) / 3};
  std::optional<double> best;
  double steepest = -1;
  for (const double x : real_roots(c)) {
    const double slope = std::abs(c[1] + x * (2 * c[2] + x * 3 * c[3])) / (1 + x * x);
    if (slope > steepest) {
      steepest = slope;
      best = x;
    }
  }
  return best;
}

// A conic of rank 2 is a pair of lines l m' + m l'. With p their meeting point, C + [p]x has rank 1: row and column are
// the lines.
Few<Eigen::Vector3d, 2> lines(const Conic& c) {
  Few<Eigen::Vector3d, 2> found;
  const Conic b = adjugate(c);  // = -p p' when the lines are real
  const double b0 = -b.c00, b1 = -b.c11, b2 = -b.c22;
  Eigen::Vector3d p;
  if (b0 >= b1 && b0 >= b2)
    p = {-b.c00, -b.c01, -b.c02};
  else if (b1 >= b2)
    p = {-b.c01, -b.c11, -b.c12};
  else
    p = {-b.c02, -b.c12, -b.c22};
  const double largest = std::max(b0, std::max(b1, b2));
  if (!(largest > 0)) return found;
  p /= std::sqrt(largest);
  const std::array<Eigen::Vector3d, 3> rows = {Eigen::Vector3d(c.c00, c.c01 - p.z(), c.c02 + p.y()),
                                               Eigen::Vector3d(c.c01 + p.z(), c.c11, c.c12 - p.x()),
                                               Eigen::Vector3d(c.c02 - p.y(), c.c12 + p.x(), c.c22)};
  std::size_t row = 0;
  int col = 0;
  double size = -1;
  for (std::size_t i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (std::abs(rows[i][j]) > size) {
        size = std::abs(rows[i][j]);
        row = i;
        col = j;
      }
  if (!(size > 0)) return found;
  found.add(rows[row]);
  found.add({rows[0][col], rows[1][col], rows[2][col]});
  return found;
}

struct Triangle {
  double a12, a13, a23;  // squared sides
  double b12, b13, b23;  // cosines between the rays
};

// Distances (up to scale) on the line l' d = 0 and the conic, all positive, brought to the scale of the triangle.
void add_distances(const Eigen::Vector3d& l, const Conic& conic, const Triangle& t, Few<Eigen::Vector3d, 4>& found) {
  int k = 0;
  l.cwiseAbs().maxCoeff(&k);
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  Eigen::Vector3d u, v;
  u[i] = 1, u[j] = 0, u[k] = -l[i] / l[k];
  v[i] = 0, v[j] = 1, v[k] = -l[j] / l[k];
  const std::array<double, 3> c = {conic.at(u, u), 2 * conic.at(u, v), conic.at(v, v)};
  for (const double ratio : real_roots(c)) {
    const Eigen::Vector3d d = u + ratio * v;
    if (!(ratio > 0 && d[k] > 0) || found.count == 4) continue;
    const double sides = 2 * (d.squaredNorm() - d.x() * d.y() * t.b12 - d.x() * d.z() * t.b13 - d.y() * d.z() * t.b23);
    if (!(sides > 0)) continue;
    found.add(d * std::sqrt((t.a12 + t.a13 + t.a23) / sides));
  }
}

// Newton's method on the three distance equations.
Eigen::Vector3d polished(Eigen::Vector3d d, const Triangle& t) {
  for (int iteration = 0; iteration < 3; ++iteration) {
    const double e12 = d.x() * d.x() + d.y() * d.y() - 2 * t.b12 * d.x() * d.y() - t.a12;
    const double e13 = d.x() * d.x() + d.z() * d.z() - 2 * t.b13 * d.x() * d.z() - t.a13;
    const double e23 = d.y() * d.y() + d.z() * d.z() - 2 * t.b23 * d.y() * d.z() - t.a23;
    if (std::abs(e12) + std::abs(e13) + std::abs(e23) < 1e-15) break;
    // Half the Jacobian: [p q 0; r 0 s; 0 v w].
    const double p = d.x() - t.b12 * d.y(), q = d.y() - t.b12 * d.x(), r = d.x() - t.b13 * d.z();
    const double s = d.z() - t.b13 * d.x(), v = d.y() - t.b23 * d.z(), w = d.z() - t.b23 * d.y();
    const double determinant = -p * s * v - q * r * w;
    if (!(std::abs(determinant) > 1e-12)) break;
    const double f = 0.5 / determinant;
    const Eigen::Vector3d step =
        f * Eigen::Vector3d(-s * v * e12 - q * w * e13 + q * s * e23, -r * w * e12 + p * w * e13 - p * s * e23,
                            r * v * e12 - p * v * e13 - q * r * e23);
    if (!(step.squaredNorm() < 0.01 * d.squaredNorm())) break;
    d -= step;
  }
  return d;
}

// Orthonormal axes carried by a triangle.
Eigen::Matrix3d axes(const Eigen::Vector3d& side12, const Eigen::Vector3d& side13) {
  Eigen::Matrix3d m;
  m.col(0) = side12.normalized();
  m.col(2) = side12.cross(side13).normalized();
  m.col(1) = m.col(2).cross(m.col(0));
  return m;
}

}  // namespace

Few<Rigid3, 4> p3p(const std::array<Eigen::Vector3d, 3>& rays_in_cam,
                   const std::array<Eigen::Vector3d, 3>& points_in_world) {
  Few<Rigid3, 4> found;
  const Eigen::Vector3d side12 = points_in_world[1] - points_in_world[0];
  const Eigen::Vector3d side13 = points_in_world[2] - points_in_world[0];
  const double largest = std::max({side12.squaredNorm(), side13.squaredNorm(), (side13 - side12).squaredNorm()});
  if (!(side12.cross(side13).squaredNorm() > 1e-12 * largest * largest)) return found;
  const Triangle t{
      side12.squaredNorm() / largest,     side13.squaredNorm() / largest,     (side13 - side12).squaredNorm() / largest,
      rays_in_cam[0].dot(rays_in_cam[1]), rays_in_cam[0].dot(rays_in_cam[2]), rays_in_cam[1].dot(rays_in_cam[2])};
  if (!(std::max({t.b12, t.b13, t.b23}) < 1 - 1e-14)) return found;

  // d' M12 d = a12 and so on; the differences a23 M12 - a12 M23 and a23 M13 - a13 M23 are homogeneous.
  const Conic first{t.a23, -t.a23 * t.b12, 0, t.a23 - t.a12, t.a12 * t.b23, -t.a12};
  const Conic second{t.a23, 0, -t.a23 * t.b13, -t.a13, t.a13 * t.b23, t.a23 - t.a13};
  const auto root = best_root(first, second);
  if (!root) return found;
  const Conic degenerate = combined(first, *root, second);
  const Conic& other = std::abs(*root) < 1 ? second : first;  // the one that differs more from the degenerate member

  Few<Eigen::Vector3d, 4> distances;
  for (const Eigen::Vector3d& line : lines(degenerate)) add_distances(line, other, t, distances);
  const Eigen::Matrix3d axes_in_world = axes(side12, side13);
  const double scale = std::sqrt(largest);
  for (const Eigen::Vector3d& start : distances) {
    const Eigen::Vector3d d = polished(start, t) * scale;
    if (!(d.minCoeff() > 0)) continue;
    const Eigen::Vector3d first_in_cam = d.x() * rays_in_cam[0];
    const Eigen::Matrix3d rotation =
        axes(d.y() * rays_in_cam[1] - first_in_cam, d.z() * rays_in_cam[2] - first_in_cam) * axes_in_world.transpose();
    found.add({Eigen::Quaterniond(rotation), first_in_cam - rotation * points_in_world[0]});
  }
  return found;
}

}  // namespace collinea
