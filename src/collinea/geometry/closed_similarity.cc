// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/closed_similarity.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "collinea/base/result.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Sums over points reduced to their centroids.
struct Moments {
  Vector3d mean_a = Vector3d::Zero(), mean_b = Vector3d::Zero();
  Matrix3d cross = Matrix3d::Zero();  // b a'
  Matrix3d of_a = Matrix3d::Zero();
  double spread_a = 0, spread_b = 0;

  [[nodiscard]] double scale() const { return std::sqrt(spread_b / spread_a); }
  [[nodiscard]] Similarity3 with(const Matrix3d& rotation) const {
    const Similarity3 turned{scale(), Eigen::Quaterniond(rotation).normalized(), Vector3d::Zero()};
    return {turned.scale, turned.rotation, mean_b - turned * mean_a};
  }
};

std::optional<Moments> moments_of(std::span<const Vector3d> a, std::span<const Vector3d> b) {
  COLLINEA_CHECK(a.size() == b.size());
  if (a.size() < 3) return std::nullopt;
  Moments m;
  for (std::size_t i = 0; i < a.size(); ++i) {
    m.mean_a += a[i] / double(a.size());
    m.mean_b += b[i] / double(a.size());
  }
  Matrix3d of_b = Matrix3d::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vector3d in_a = a[i] - m.mean_a, in_b = b[i] - m.mean_b;
    m.cross += in_b * in_a.transpose();
    m.of_a += in_a * in_a.transpose();
    of_b += in_b * in_b.transpose();
  }
  m.spread_a = m.of_a.trace();
  m.spread_b = of_b.trace();
  constexpr double kLine = 1e-12;  // second axis of the spread over the first
  for (const Matrix3d& spread : {m.of_a, of_b}) {
    const Vector3d axes = Eigen::SelfAdjointEigenSolver<Matrix3d>(spread).eigenvalues();
    if (!(axes[1] > kLine * axes[2])) return std::nullopt;
  }
  return m;
}

// The system of Mussio 4.1.3, summed up: [X-u] = [X+u]x abc for X = R' u of equal lengths.
std::optional<Vector3d> linear_rodrigues(std::span<const Vector3d> a, std::span<const Vector3d> b, const Moments& m,
                                         const Matrix3d& first) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vector3d u = m.scale() * (first * (a[i] - m.mean_a)), x = b[i] - m.mean_b, sum = x + u, difference = x - u;
    Matrix3d rows;
    rows << 0, sum.z(), -sum.y(), -sum.z(), 0, sum.x(), sum.y(), -sum.x(), 0;
    normal += rows.transpose() * rows;
    right -= rows.transpose() * difference;
  }
  const Eigen::LDLT<Matrix3d> factor(normal);
  if (!(factor.vectorD().minCoeff() > 1e-12 * normal.trace())) return std::nullopt;
  return factor.solve(right);
}

Matrix3d rotation_of(const Vector3d& abc) {
  Matrix3d s;
  s << 0, abc.z(), -abc.y(), -abc.z(), 0, abc.x(), abc.y(), -abc.x(), 0;
  const Matrix3d difference = Matrix3d::Identity() - s;
  return difference.inverse() * (Matrix3d::Identity() + s);
}

}  // namespace

std::optional<Similarity3> align_by_quaternion(std::span<const Vector3d> points_in_a,
                                               std::span<const Vector3d> points_in_b) {
  const auto m = moments_of(points_in_a, points_in_b);
  if (!m) return std::nullopt;
  const Matrix3d s = m->cross.transpose();  // s(i, j): sum of a_i b_j
  Eigen::Matrix4d n;
  n << s.trace(), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2), s(0, 1) - s(1, 0),                    //
      s(1, 2) - s(2, 1), s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0), s(2, 0) + s(0, 2),   //
      s(2, 0) - s(0, 2), s(0, 1) + s(1, 0), -s(0, 0) + s(1, 1) - s(2, 2), s(1, 2) + s(2, 1),  //
      s(0, 1) - s(1, 0), s(2, 0) + s(0, 2), s(1, 2) + s(2, 1), -s(0, 0) - s(1, 1) + s(2, 2);
  const Eigen::Vector4d q = Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d>(n).eigenvectors().col(3);
  return m->with(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix());
}

std::optional<RodriguesFit> align_by_rodrigues(std::span<const Vector3d> points_in_a,
                                               std::span<const Vector3d> points_in_b) {
  const auto m = moments_of(points_in_a, points_in_b);
  if (!m) return std::nullopt;
  constexpr double kFarTurn = 2.5;  // |abc| = tan(angle / 2): beyond 136 degrees another start is better
  std::optional<RodriguesFit> best;
  double shortest = std::numeric_limits<double>::infinity();
  for (int axis = -1; axis < 3; ++axis) {
    Matrix3d first = Matrix3d::Identity();
    if (axis >= 0) first = 2 * Vector3d::Unit(axis) * Vector3d::Unit(axis).transpose() - first;
    const auto abc = linear_rodrigues(points_in_a, points_in_b, *m, first);
    if (!abc || !(abc->norm() < shortest)) continue;
    shortest = abc->norm();
    best = RodriguesFit{m->with(rotation_of(*abc) * first), *abc, axis >= 0};
    if (shortest < kFarTurn) break;
  }
  return best;
}

}  // namespace collinea
