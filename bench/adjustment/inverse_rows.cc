// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "blocks.h"
#include "collinea/geometry/rotation.h"
#include "dense.h"
#include "rows.h"

namespace collinea::bench {
namespace {

const std::vector<int> kBrown = {Camera::kF,  Camera::kCx, Camera::kCy, Camera::kK1,
                                 Camera::kK2, Camera::kK3, Camera::kP1, Camera::kP2};

// The largest difference of two covariances, in units of their standard deviations.
double difference(const Eigen::MatrixXd& is, const Eigen::MatrixXd& should) {
  const Eigen::VectorXd scale = should.diagonal().cwiseSqrt().cwiseInverse();
  return (scale.asDiagonal() * (is - should) * scale.asDiagonal()).cwiseAbs().maxCoeff();
}

}  // namespace

Rows dense_inverse(const Run& run) {
  double worst[4] = {};
  for (const Layout layout : {Layout::kCrossStrips, Layout::kRing, Layout::kCorridor}) {
    const Measured made = measured(exact_block(layout, {.points = 90, .control = 5}, 7), 7);
    ExamineOptions options = exact_options(Calibration::kBrown);
    options.point_covariances = true;
    const auto adjusted = examine(made.block, made.scope, options, run);
    if (!adjusted || adjusted->undetermined) return {{"covariances", "", "not adjusted", false}};
    const DenseNormals normals = dense_normals(made.block, *adjusted, made.scope, kBrown);
    const DenseMatrix inverse = inverse_of(normals.matrix);
    const auto compare = [&](int kind, const Eigen::MatrixXd& is, int row) {
      worst[kind] = std::max(worst[kind], difference(is, normals.part(inverse, row, static_cast<int>(is.rows()))));
    };
    for (const auto& [id, covariance] : adjusted->pose_covariance) compare(0, covariance, normals.image.at(id));
    for (std::size_t i = 0; i < adjusted->points.size(); ++i)
      compare(1, adjusted->point_covariance[i], normals.point.at(adjusted->points[i].first));
    for (const auto& [id, covariance] : adjusted->camera_covariance)
      compare(2, covariance.topLeftCorner<8, 8>(), normals.camera.at(id));
    for (const ControlDifference& control : adjusted->control)
      if (control.used) compare(3, *control.covariance_m2, normals.control.at(control.point));
  }
  const double all = std::max({worst[0], worst[1], worst[2], worst[3]});
  return {{"covariances against a dense inverse", "equal to 1e-8 of the standard deviations",
           fmt::format("poses {:.0e}, points {:.0e}, cameras {:.0e}, control {:.0e}", worst[0], worst[1], worst[2],
                       worst[3]),
           all < 1e-8}};
}

namespace {

// How the unknowns follow shift, turn and scale of the world.
DenseMatrix motions_of(const DenseNormals& normals, const Examined& adjusted) {
  DenseMatrix g = DenseMatrix::Zero(normals.matrix.rows(), 7);
  const auto at = [&](int row, const Eigen::Vector3d& x) {
    Eigen::Matrix<double, 3, 7> m;
    m << Eigen::Matrix3d::Identity(), -skew(x), x;
    g.middleRows(row, 3) = m.cast<long double>();
  };
  for (const auto& [id, row] : normals.image) {
    g.block(row, 3, 3, 3) = -DenseMatrix::Identity(3, 3);
    at(row + 3, centre_of(adjusted.cam_from_world.at(id)));
  }
  for (const auto& [id, position] : adjusted.points) at(normals.point.at(id), position);
  return g;
}

// With the coordinates of some points held: seven of three points.
DenseMatrix constrained_inverse(const DenseMatrix& matrix, const std::vector<int>& fixed) {
  std::vector<int> free;
  for (int i = 0; i < matrix.rows(); ++i)
    if (std::find(fixed.begin(), fixed.end(), i) == fixed.end()) free.push_back(i);
  const auto size = static_cast<int>(free.size());
  DenseMatrix part(size, size), whole = DenseMatrix::Zero(matrix.rows(), matrix.cols());
  for (int i = 0; i < size; ++i)
    for (int k = 0; k < size; ++k) part(i, k) = matrix(free[i], free[k]);
  part = inverse_of(part);
  for (int i = 0; i < size; ++i)
    for (int k = 0; k < size; ++k) whole(free[i], free[k]) = part(i, k);
  return whole;
}

}  // namespace

Rows free_network(const Run& run) {
  const Measured made = measured(exact_block(Layout::kRing, {.points = 70, .control = 0}, 11), 11);
  ExamineOptions options = exact_options(Calibration::kBrown);
  options.point_covariances = true;
  const auto adjusted = examine(made.block, made.scope, options, run);
  if (!adjusted || adjusted->point_covariance.empty()) return {{"free network", "", "not adjusted", false}};
  const DenseNormals normals = dense_normals(made.block, *adjusted, made.scope, kBrown);
  std::vector<int> rows;
  for (const auto& [id, row] : normals.point) rows.push_back(row);
  const std::size_t n = rows.size();
  const DenseMatrix g = motions_of(normals, *adjusted);
  DenseMatrix points = DenseMatrix::Zero(g.rows(), 7);  // only of the points
  for (const int row : rows) points.middleRows(row, 3) = g.middleRows(row, 3);
  const DenseMatrix m = inverse_of(points.transpose() * points);
  double least_other = std::numeric_limits<double>::infinity(), trace = 0, is = 0, worst = 0;
  for (const auto& [a, b, c] : {std::tuple(std::size_t{0}, n / 2, n - 1), std::tuple(n / 4, n / 3, 3 * n / 4)}) {
    const DenseMatrix constrained = constrained_inverse(
        normals.matrix, {rows[a], rows[a] + 1, rows[a] + 2, rows[b], rows[b] + 1, rows[b] + 2, rows[c] + 2});
    const DenseMatrix s = DenseMatrix::Identity(g.rows(), g.rows()) - g * m * points.transpose();
    const DenseMatrix free = s * constrained * s.transpose();
    double other = trace = is = 0;
    for (const int row : rows) other += static_cast<double>(constrained.block(row, row, 3, 3).trace());
    least_other = std::min(least_other, other);
    for (std::size_t i = 0; i < adjusted->points.size(); ++i) {
      const int row = normals.point.at(adjusted->points[i].first);
      trace += static_cast<double>(free.block(row, row, 3, 3).trace());
      is += adjusted->point_covariance[i].trace();
      worst = std::max(worst, difference(adjusted->point_covariance[i], normals.part(free, row, 3)));
    }
    for (const auto& [id, covariance] : adjusted->pose_covariance)
      worst = std::max(worst, difference(covariance, normals.part(free, normals.image.at(id), 6)));
  }
  return {{"free network: covariances against the S-transformed constrained solution", "equal to 1e-6, two constraints",
           fmt::format("{:.0e}", worst), adjusted->rank_defect == 7 && worst < 1e-6},
          {"free network: trace of the points' covariance", "that of inner constraints, less than with points held",
           fmt::format("{:.6g} m2, inner constraints {:.6g}, least with points held {:.3g}", is, trace, least_other),
           std::abs(is - trace) < 1e-6 * trace && is < least_other}};
}

}  // namespace collinea::bench
