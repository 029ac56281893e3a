// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <span>
#include <vector>

#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {

/// Any part of the covariance of the reduced unknowns (poses and cameras), by solving with the Cholesky factor of their
/// normal equations: also between images that see nothing in common, which the selected inverse does not hold. By the
/// given sigmas, in the datum of the factor.
class CovarianceOfImages {
 public:
  /// `size`: how many unknowns there are.
  CovarianceOfImages(int size, TileCholesky factor) : size_(size), factor_(std::move(factor)) {}

  /// Of these rows, in their order. One solution for each that was not asked for before, as far as these fit into
  /// kMostKept.
  [[nodiscard]] Eigen::MatrixXd of(std::span<const int> rows);

 private:
  static constexpr std::size_t kMostKept = std::size_t{1} << 25;  // numbers: 256 MiB

  int size_;
  TileCholesky factor_;
  std::map<int, Eigen::VectorXd> columns_;
};

}  // namespace collinea::bundle
