// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "collinea/quality/examine.h"

namespace collinea::bench {

using DenseMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

/// The normal equations of a whole block at the adjusted place, without elimination, tiles or selected inverse, in
/// extended precision, from the camera model alone. Unknowns: 6 of each image (rotation in the world, centre), the free
/// parameters of each camera, 3 of each tie and control point. No robust loss.
struct DenseNormals {
  DenseMatrix matrix;
  std::map<ImageId, int> image;
  std::map<CameraId, int> camera;
  std::vector<int> free;  ///< Camera::Param of a camera's rows
  std::map<PointId, int> point;
  std::map<ControlId, int> control;

  [[nodiscard]] Eigen::MatrixXd part(const DenseMatrix& whole, int row, int size) const {
    return whole.block(row, row, size, size).cast<double>();
  }
};

[[nodiscard]] DenseNormals dense_normals(const Block& measured, const Examined& adjusted, const AdjustScope& scope,
                                         const std::vector<int>& free);

/// Inverse of a positive definite matrix, scaled to ones on the diagonal first.
[[nodiscard]] DenseMatrix inverse_of(const DenseMatrix& matrix);

}  // namespace collinea::bench
