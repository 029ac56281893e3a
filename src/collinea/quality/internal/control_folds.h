// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/base/run.h"

namespace collinea {

/// What a surveyed point would have been found to be off by, had its coordinates not taken part.
struct LeftOutPoint {
  ControlId point;
  Eigen::Vector3d difference_m;        ///< estimated minus given; NaN on axes not surveyed
  Eigen::Vector3d difference_sigma_m;  ///< expected of it, with sigma0
};

/// Control points left out in parts, each predicted by the others.
struct Folded {
  int folds = 0;                     ///< parts; 0: too few points (or too many), none were left out
  std::vector<int> part;             ///< of each point, from 1
  std::vector<LeftOutPoint> points;  ///< of parts without which the block is determined, in the order of ControlId
};

/// Root mean squares over points that were left out: of differences, and what their sigmas predict.
struct LeftOutRms {
  int points = 0;
  double difference_m = 0, predicted_m = 0;
};
/// In plan (of both axes together, points surveyed on both), or in height.
[[nodiscard]] LeftOutRms rms_of(const std::vector<LeftOutPoint>& points, bool height);

namespace bundle {

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
  ControlFolds(const Solved& solved, const TileCholesky& factor, const Run& run);

  /// In so many parts, each spread over the block and of two points and more; fewer parts where there are few points,
  /// none below four.
  [[nodiscard]] Folded leave_out(const Solved& solved, const Adjusted& adjusted, int folds) const;

 private:
  [[nodiscard]] std::vector<std::size_t> spread(const State& state) const;

  std::vector<std::size_t> points_;  // numbers in Problem::points
  Eigen::MatrixXd cofactor_;         // of their coordinates
};

}  // namespace bundle
}  // namespace collinea
