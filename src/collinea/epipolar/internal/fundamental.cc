// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/fundamental.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cmath>
#include <utility>

#include "collinea/math/polynomial.h"

namespace collinea {
namespace {

using Row = std::array<double, 9>;

// Gauss-Jordan elimination with full pivoting of seven rows; then the two null vectors are read off.
bool null_space(std::array<Row, 7>& rows, std::array<Row, 2>& basis) {
  std::array<std::size_t, 9> column = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  for (std::size_t k = 0; k < 7; ++k) {
    std::size_t row = k, col = k;
    for (std::size_t i = k; i < 7; ++i)
      for (std::size_t j = k; j < 9; ++j)
        if (std::abs(rows[i][column[j]]) > std::abs(rows[row][column[col]])) {
          row = i;
          col = j;
        }
    if (!(std::abs(rows[row][column[col]]) > 1e-10)) return false;
    std::swap(rows[k], rows[row]);
    std::swap(column[k], column[col]);
    const double inverse = 1 / rows[k][column[k]];
    for (std::size_t j = k; j < 9; ++j) rows[k][column[j]] *= inverse;
    for (std::size_t i = 0; i < 7; ++i) {
      if (i == k) continue;
      const double factor = rows[i][column[k]];
      for (std::size_t j = k; j < 9; ++j) rows[i][column[j]] -= factor * rows[k][column[j]];
    }
  }
  for (std::size_t n = 0; n < 2; ++n) {
    basis[n].fill(0);
    basis[n][column[7 + n]] = 1;
    for (std::size_t k = 0; k < 7; ++k) basis[n][column[k]] = -rows[k][column[7 + n]];
  }
  return true;
}

Eigen::Matrix3d matrix(const Row& row) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(row.data());
}

Eigen::Matrix3d cofactors(const Eigen::Matrix3d& m) {
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d a = m.row((i + 1) % 3), b = m.row((i + 2) % 3);
    c.row(i) = a.cross(b).transpose();
  }
  return c;
}

// Brings points to centroid 0 and root-mean-square distance sqrt(2).
struct Normalisation {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double scale = 1;

  [[nodiscard]] Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d m;
    m << scale, 0, -scale * centre.x(), 0, scale, -scale * centre.y(), 0, 0, 1;
    return m;
  }
};

template <class PointOf>
std::optional<Normalisation> normalisation(std::span<const int> support, PointOf point) {
  Normalisation n;
  for (const int i : support) n.centre += point(i);
  n.centre /= static_cast<double>(support.size());
  double squared = 0;
  for (const int i : support) squared += (point(i) - n.centre).squaredNorm();
  if (!(squared > 0)) return std::nullopt;
  n.scale = std::sqrt(2 * static_cast<double>(support.size()) / squared);
  return n;
}

}  // namespace

Few<Eigen::Matrix3d, 3> seven_point(const std::array<Eigen::Vector2d, 7>& first,
                                    const std::array<Eigen::Vector2d, 7>& second) {
  Few<Eigen::Matrix3d, 3> found;
  std::array<Row, 7> rows;
  for (std::size_t i = 0; i < 7; ++i) {
    const double x1 = first[i].x(), y1 = first[i].y(), x2 = second[i].x(), y2 = second[i].y();
    rows[i] = {x2 * x1, x2 * y1, x2, y2 * x1, y2 * y1, y2, x1, y1, 1};
  }
  std::array<Row, 2> basis;
  if (!null_space(rows, basis)) return found;
  const Eigen::Matrix3d a = matrix(basis[0]).normalized(), b = matrix(basis[1]).normalized();
  const Eigen::Matrix3d cofactors_a = cofactors(a), cofactors_b = cofactors(b);
  const double det_a = a.row(0).dot(cofactors_a.row(0)), det_b = b.row(0).dot(cofactors_b.row(0));
  // det(a + x b) = det a + x <cof a, b> + x^2 <a, cof b> + x^3 det b
  const std::array<double, 4> c = {det_a, cofactors_a.cwiseProduct(b).sum(), a.cwiseProduct(cofactors_b).sum(), det_b};
  for (const double x : real_roots(c)) found.add((a + x * b).normalized());
  return found;
}

std::optional<Eigen::Matrix3d> eight_point(const PointPairs& pairs, std::span<const int> support) {
  if (support.size() < 8) return std::nullopt;
  const auto in_first = normalisation(support, [&](int i) { return pairs.first(i); });
  const auto in_second = normalisation(support, [&](int i) { return pairs.second(i); });
  if (!in_first || !in_second) return std::nullopt;

  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  Matrix9 normal = Matrix9::Zero();
  for (const int i : support) {
    const Eigen::Vector3d p = ((pairs.first(i) - in_first->centre) * in_first->scale).homogeneous();
    const Eigen::Vector3d q = ((pairs.second(i) - in_second->centre) * in_second->scale).homogeneous();
    Eigen::Matrix<double, 9, 1> row;
    row << q.x() * p, q.y() * p, p;
    normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
  }
  const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(normal);
  if (!(eigen.eigenvalues()(1) > 1e-12 * eigen.eigenvalues()(8))) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> smallest = eigen.eigenvectors().col(0);
  const Eigen::Matrix3d linear = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(smallest.data());
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d singular = svd.singularValues();
  singular.z() = 0;
  const Eigen::Matrix3d rank_two = svd.matrixU() * singular.asDiagonal() * svd.matrixV().transpose();
  return (in_second->matrix().transpose() * rank_two * in_first->matrix()).normalized();
}

}  // namespace collinea
