// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/essential.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

#include "collinea/geometry/rotation.h"
#include "collinea/math/polynomial.h"

namespace collinea {
namespace {

// E = x X + y Y + z Z + W. Coefficients of polynomials in x, y, z:
using Linear = std::array<double, 4>;      // x, y, z, 1
using Quadratic = std::array<double, 10>;  // xx, xy, yy, xz, yz, zz, x, y, z, 1
// Nister's order of the cubic monomials: elimination of the first ten leaves what is linear in x and y.
//   0 xxx  1 yyy  2 xxy  3 xyy  4 xxz  5 xx  6 yyz  7 yy  8 xyz  9 xy | 10 xzz 11 xz 12 x 13 yzz 14 yz 15 y 16 zzz 17
//   zz 18 z 19 1
using Cubic = std::array<double, 20>;

inline void add_product(const Linear& a, const Linear& b, double sign, Quadratic& sum) {
  sum[0] += sign * (a[0] * b[0]);
  sum[1] += sign * (a[0] * b[1] + a[1] * b[0]);
  sum[2] += sign * (a[1] * b[1]);
  sum[3] += sign * (a[0] * b[2] + a[2] * b[0]);
  sum[4] += sign * (a[1] * b[2] + a[2] * b[1]);
  sum[5] += sign * (a[2] * b[2]);
  sum[6] += sign * (a[0] * b[3] + a[3] * b[0]);
  sum[7] += sign * (a[1] * b[3] + a[3] * b[1]);
  sum[8] += sign * (a[2] * b[3] + a[3] * b[2]);
  sum[9] += sign * (a[3] * b[3]);
}

inline void add_product(const Quadratic& q, const Linear& l, Cubic& sum) {
  sum[0] += q[0] * l[0];
  sum[1] += q[2] * l[1];
  sum[2] += q[0] * l[1] + q[1] * l[0];
  sum[3] += q[1] * l[1] + q[2] * l[0];
  sum[4] += q[0] * l[2] + q[3] * l[0];
  sum[5] += q[0] * l[3] + q[6] * l[0];
  sum[6] += q[2] * l[2] + q[4] * l[1];
  sum[7] += q[2] * l[3] + q[7] * l[1];
  sum[8] += q[1] * l[2] + q[3] * l[1] + q[4] * l[0];
  sum[9] += q[1] * l[3] + q[6] * l[1] + q[7] * l[0];
  sum[10] += q[3] * l[2] + q[5] * l[0];
  sum[11] += q[3] * l[3] + q[6] * l[2] + q[8] * l[0];
  sum[12] += q[6] * l[3] + q[9] * l[0];
  sum[13] += q[4] * l[2] + q[5] * l[1];
  sum[14] += q[4] * l[3] + q[7] * l[2] + q[8] * l[1];
  sum[15] += q[7] * l[3] + q[9] * l[1];
  sum[16] += q[5] * l[2];
  sum[17] += q[5] * l[3] + q[8] * l[2];
  sum[18] += q[8] * l[3] + q[9] * l[2];
  sum[19] += q[9] * l[3];
}

using Basis = std::array<std::array<double, 9>, 4>;

// Four orthonormal vectors orthogonal to the five rows, by Householder reflections of their transpose.
bool null_space(std::array<std::array<double, 9>, 5>& rows, Basis& basis) {
  std::array<std::array<double, 9>, 5> mirrors;
  for (std::size_t k = 0; k < 5; ++k) {
    auto& v = rows[k];
    double tail = 0, head = 0;
    for (std::size_t i = k; i < 9; ++i) tail += v[i] * v[i];
    for (std::size_t i = 0; i < k; ++i) head += v[i] * v[i];
    if (!(tail > 1e-14 * (head + tail))) return false;
    auto& mirror = mirrors[k];
    const double norm = std::copysign(std::sqrt(tail), v[k]), scale = 1 / std::sqrt(tail + norm * v[k]);
    for (std::size_t i = k; i < 9; ++i) mirror[i] = v[i] * scale;  // |mirror|^2 = 2
    mirror[k] += norm * scale;
    for (std::size_t j = k + 1; j < 5; ++j) {
      double dot = 0;
      for (std::size_t i = k; i < 9; ++i) dot += mirror[i] * rows[j][i];
      for (std::size_t i = k; i < 9; ++i) rows[j][i] -= dot * mirror[i];
    }
  }
  for (std::size_t n = 0; n < 4; ++n) {
    auto& e = basis[n];
    e.fill(0);
    e[5 + n] = 1;
    for (std::size_t k = 5; k-- > 0;) {
      double dot = 0;
      for (std::size_t i = k; i < 9; ++i) dot += mirrors[k][i] * e[i];
      for (std::size_t i = k; i < 9; ++i) e[i] -= dot * mirrors[k][i];
    }
  }
  return true;
}

// det E = 0 and 2 E E' E - trace(E E') E = 0: ten cubic equations.
void constraints(const Basis& basis, std::array<Cubic, 10>& equations) {
  std::array<Linear, 9> e;  // row-major entries of E
  for (std::size_t i = 0; i < 9; ++i) e[i] = {basis[0][i], basis[1][i], basis[2][i], basis[3][i]};

  std::array<Quadratic, 9> square{};  // E E' - trace / 2
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j <= i; ++j)
      for (std::size_t k = 0; k < 3; ++k) add_product(e[3 * i + k], e[3 * j + k], 1, square[3 * i + j]);
  for (std::size_t m = 0; m < 10; ++m) {
    const double half_trace = (square[0][m] + square[4][m] + square[8][m]) / 2;
    for (const std::size_t d : {0u, 4u, 8u}) square[d][m] -= half_trace;
  }
  square[1] = square[3];
  square[2] = square[6];
  square[5] = square[7];

  for (Cubic& equation : equations) equation.fill(0);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) add_product(square[3 * i + k], e[3 * k + j], equations[3 * i + j]);
  for (std::size_t j = 0; j < 3; ++j) {
    const std::size_t a = (j + 1) % 3, b = (j + 2) % 3;
    Quadratic minor{};
    add_product(e[3 + a], e[6 + b], 1, minor);
    add_product(e[3 + b], e[6 + a], -1, minor);
    add_product(minor, e[j], equations[9]);
  }
}

// Gauss elimination with row pivoting of the first ten columns; only rows 4 to 9 are cleared above the diagonal too.
bool eliminate(std::array<Cubic, 10>& rows) {
  for (std::size_t k = 0; k < 10; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < 10; ++i)
      if (std::abs(rows[i][k]) > std::abs(rows[pivot][k])) pivot = i;
    if (!(std::abs(rows[pivot][k]) > 1e-14)) return false;
    if (pivot != k) std::swap(rows[k], rows[pivot]);
    const double inverse = 1 / rows[k][k];
    for (std::size_t c = k; c < 20; ++c) rows[k][c] *= inverse;
    for (std::size_t i = k + 1; i < 10; ++i) {
      const double factor = rows[i][k];
      for (std::size_t c = k + 1; c < 20; ++c) rows[i][c] -= factor * rows[k][c];
    }
  }
  for (std::size_t k = 9; k > 4; --k)
    for (std::size_t i = 4; i < k; ++i) {
      const double factor = rows[i][k];
      for (std::size_t c = 10; c < 20; ++c) rows[i][c] -= factor * rows[k][c];
    }
  return true;
}

// One row of B(z) (x, y, 1)' = 0: coefficients by rising powers of z.
struct RowOfB {
  std::array<double, 4> x, y;
  std::array<double, 5> one;
};

// With e: xxz + ..., f: xx + ..., the difference e - z f is free of products of x and y.
RowOfB difference(const Cubic& e, const Cubic& f) {
  return {{e[12], e[11] - f[12], e[10] - f[11], -f[10]},
          {e[15], e[14] - f[15], e[13] - f[14], -f[13]},
          {e[19], e[18] - f[19], e[17] - f[18], e[16] - f[17], -f[16]}};
}

template <std::size_t N, std::size_t M>
std::array<double, N + M - 1> product(const std::array<double, N>& a, const std::array<double, M>& b) {
  std::array<double, N + M - 1> c{};
  for (std::size_t i = 0; i < N; ++i)
    for (std::size_t j = 0; j < M; ++j) c[i + j] += a[i] * b[j];
  return c;
}

std::array<double, 11> determinant(const std::array<RowOfB, 3>& b) {
  std::array<double, 11> sum{};
  for (std::size_t i = 0; i < 3; ++i) {
    const RowOfB &p = b[(i + 1) % 3], &q = b[(i + 2) % 3];
    auto minor = product(p.x, q.y);
    const auto other = product(q.x, p.y);
    for (std::size_t k = 0; k < minor.size(); ++k) minor[k] -= other[k];
    const auto term = product(minor, b[i].one);
    for (std::size_t k = 0; k < 11; ++k) sum[k] += term[k];
  }
  return sum;
}

template <std::size_t N>
double at(const std::array<double, N>& c, double z) {
  double sum = c[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * z + c[i];
  return sum;
}

// (x, y) for a root z: the null vector of B(z), as the largest of the cross products of its rows.
std::optional<Eigen::Vector2d> xy_at(const std::array<RowOfB, 3>& b, double z) {
  std::array<Eigen::Vector3d, 3> rows;
  for (std::size_t i = 0; i < 3; ++i) rows[i] = {at(b[i].x, z), at(b[i].y, z), at(b[i].one, z)};
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d candidate = rows[i].cross(rows[(i + 1) % 3]);
    if (candidate.squaredNorm() > best.squaredNorm()) best = candidate;
  }
  if (!(std::abs(best.z()) > 1e-10 * best.norm())) return std::nullopt;
  return best.head<2>() / best.z();
}

}  // namespace

Few<Eigen::Matrix3d, 10> five_point(const std::array<Eigen::Vector2d, 5>& first,
                                    const std::array<Eigen::Vector2d, 5>& second) {
  Few<Eigen::Matrix3d, 10> found;
  std::array<std::array<double, 9>, 5> rows;
  for (std::size_t i = 0; i < 5; ++i) {
    const double x1 = first[i].x(), y1 = first[i].y(), x2 = second[i].x(), y2 = second[i].y();
    rows[i] = {x2 * x1, x2 * y1, x2, y2 * x1, y2 * y1, y2, x1, y1, 1};
  }
  Basis basis;
  if (!null_space(rows, basis)) return found;
  std::array<Cubic, 10> equations;
  constraints(basis, equations);
  if (!eliminate(equations)) return found;

  const std::array<RowOfB, 3> b = {difference(equations[4], equations[5]), difference(equations[6], equations[7]),
                                   difference(equations[8], equations[9])};
  for (const double z : real_roots(determinant(b))) {
    const auto xy = xy_at(b, z);
    if (!xy) continue;
    Eigen::Matrix3d essential;
    double squared = 0;
    for (int i = 0; i < 9; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double entry = xy->x() * basis[0][k] + xy->y() * basis[1][k] + z * basis[2][k] + basis[3][k];
      essential(i / 3, i % 3) = entry;
      squared += entry * entry;
    }
    found.add(essential * std::sqrt(2 / squared));
  }
  return found;
}

Eigen::Matrix3d essential_matrix(const Rigid3& second_from_first) {
  return skew(second_from_first.translation) * second_from_first.rotation.toRotationMatrix();
}

std::array<Rigid3, 4> motions(const Eigen::Matrix3d& essential) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU(), v = svd.matrixV();
  if (u.determinant() < 0) u.col(2) *= -1;
  if (v.determinant() < 0) v.col(2) *= -1;
  Eigen::Matrix3d quarter_turn;
  quarter_turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Quaterniond one(Eigen::Matrix3d(u * quarter_turn * v.transpose()));
  const Eigen::Quaterniond other(Eigen::Matrix3d(u * quarter_turn.transpose() * v.transpose()));
  const Eigen::Vector3d t = u.col(2);
  return {Rigid3{one.normalized(), t}, Rigid3{one.normalized(), -t}, Rigid3{other.normalized(), t},
          Rigid3{other.normalized(), -t}};
}

RayMeeting meeting(const Rigid3& second_from_first, const Eigen::Vector2d& first, const Eigen::Vector2d& second) {
  // depth2 b = depth1 a + t with a, b the rays in the second frame; crossed with b and with a.
  const Eigen::Vector3d a = second_from_first.rotation * first.homogeneous(), b = second.homogeneous();
  const Eigen::Vector3d normal = a.cross(b), &t = second_from_first.translation;
  const double squared = normal.squaredNorm();
  const double angle = std::atan2(std::sqrt(squared), a.dot(b));
  if (squared == 0) {
    const double infinity = std::numeric_limits<double>::infinity();
    return {infinity, infinity, angle};
  }
  return {-t.cross(b).dot(normal) / squared, -t.cross(a).dot(normal) / squared, angle};
}

std::optional<Rigid3> in_front(std::span<const Rigid3> candidates, const PointPairs& pairs,
                               std::span<const int> support, double min_angle_rad) {
  std::optional<Rigid3> best;
  int most = 0;
  for (const Rigid3& candidate : candidates) {
    int good = 0, asked = 0;
    for (const int i : support) {
      const RayMeeting at = meeting(candidate, pairs.first(i), pairs.second(i));
      if (at.angle_rad < min_angle_rad) continue;
      ++asked;
      good += at.depth_first > 0 && at.depth_second > 0;
    }
    if (good > most && 2 * good > asked) {
      most = good;
      best = candidate;
    }
  }
  return best;
}

}  // namespace collinea
