// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/point_cofactor.h"
#include "collinea/adjust/problem.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {

/// Points without their own coordinates, by the cofactor Q of the adjusted ones, three rows of each, their differences
/// d (adjusted minus given), weights P (0: not surveyed on that axis) and the variances `survey` of these: they lie at
/// given + (I - Q P)^-1 d then, with the cofactor (I - Q P)^-1 Q, which `variance` multiplies. Exact for linear
/// equations. None when they are not determined.
[[nodiscard]] std::vector<LeftOutPoint> without_coordinates(const std::vector<ControlId>& points,
                                                            const Eigen::MatrixXd& cofactor,
                                                            const Eigen::VectorXd& differences,
                                                            const Eigen::MatrixXd& weights,
                                                            const Eigen::VectorXd& survey, double variance);

/// What parts of the control would have been found to be off by, had their coordinates not taken part: leave-one-out
/// flatters where neighbours have the same error. Exact for linear equations.
class ControlFolds {
 public:
  /// The cofactors of all surveyed points with all their correlations, by three solutions for each with the Cholesky
  /// factor. More than 500 points are left alone.
  ControlFolds(const Problem& problem, const State& state, const TileCholesky& factor, const Run& run);

  /// In so many parts, each spread over the block and of two points and more; fewer parts where there are few points,
  /// none below four.
  [[nodiscard]] Folded leave_out(const Problem& problem, const State& state, const Adjusted& adjusted, int folds) const;

 private:
  [[nodiscard]] std::vector<std::size_t> spread(const State& state) const;

  std::vector<std::size_t> points_;  // numbers in Problem::points
  Eigen::MatrixXd cofactor_;         // of their coordinates
};

}  // namespace collinea::bundle
