// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/point_cofactor.h"
#include "collinea/adjust/problem.h"
#include "collinea/adjust/tile_cholesky.h"

namespace collinea::bundle {

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
