// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "blocks.h"
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
    AdjustOptions options = exact_options("brown");
    options.covariances = options.point_covariances = true;
    const auto adjusted = adjust(made.block, made.scope, options, run);
    if (!adjusted || !adjusted->undetermined.empty()) return {{"covariances", "", "not adjusted", false}};
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

Rows free_network(const Run&) { return {}; }

}  // namespace collinea::bench
