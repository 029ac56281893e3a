// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/similarity3.h"

#include <Eigen/SVD>

#include "collinea/base/result.h"

namespace collinea {

std::optional<Similarity3> align(std::span<const Eigen::Vector3d> points_in_a,
                                 std::span<const Eigen::Vector3d> points_in_b, std::span<const double> weights) {
  COLLINEA_CHECK(points_in_a.size() == points_in_b.size());
  COLLINEA_CHECK(weights.empty() || weights.size() == points_in_a.size());
  if (points_in_a.size() < 3) return std::nullopt;
  const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };

  double total = 0;
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero(), mean_b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < points_in_a.size(); ++i) {
    total += weight(i);
    mean_a += weight(i) * points_in_a[i];
    mean_b += weight(i) * points_in_b[i];
  }
  if (!(total > 0)) return std::nullopt;
  mean_a /= total;
  mean_b /= total;

  double spread_a = 0;
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < points_in_a.size(); ++i) {
    const Eigen::Vector3d a = points_in_a[i] - mean_a, b = points_in_b[i] - mean_b;
    spread_a += weight(i) * a.squaredNorm();
    cross += weight(i) * b * a.transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d singular = svd.singularValues();
  if (!(singular[1] > 1e-9 * singular[0]) || !(spread_a > 0)) return std::nullopt;
  Eigen::Vector3d signs(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) signs[2] = -1;

  Similarity3 b_from_a;
  b_from_a.rotation = Eigen::Quaterniond(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose()).normalized();
  b_from_a.scale = singular.dot(signs) / spread_a;
  b_from_a.translation = mean_b - b_from_a.scale * (b_from_a.rotation * mean_a);
  return b_from_a;
}

}  // namespace collinea
