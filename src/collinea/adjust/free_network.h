// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/problem.h"
#include "collinea/adjust/tile_cholesky.h"

namespace collinea::bundle {

/// Takes covariances of a block that nothing fixes entirely from the few images that held its datum to that of all tie
/// points (S-transformation, Baarda 1973): of all minimal datums the one in which the trace of the points' covariance
/// is least. Nothing changes where there is no datum defect.
class FreeNetwork {
 public:
  /// At most seven solutions for each unconnected part.
  FreeNetwork(const Problem& problem, const State& state, const TileCholesky& factor);

  /// Of [rotation in the world, centre]; `to_world` turns the internal rotation there.
  [[nodiscard]] Matrix6d of_pose(const Matrix6d& covariance, int pose, const Matrix6d& to_world) const;
  [[nodiscard]] Eigen::Matrix3d of_point(const Eigen::Matrix3d& covariance, std::size_t point) const;

 private:
  struct Part {
    Eigen::MatrixXd motions;  // 7 x k: what nothing observes
    Eigen::Vector3d centre;
    double size = 1;
    Eigen::MatrixXd with_motions;  // covariance of the reduced unknowns with the motion of the points, x k
    Eigen::MatrixXd inverse;       // of the points' motions, k x k
    Eigen::MatrixXd variance;      // of the motion of the points
  };
  [[nodiscard]] Eigen::MatrixXd of_place(const Part& part, const Eigen::Vector3d& place) const;
  static void transform(const Part& part, const Eigen::MatrixXd& moved, const Eigen::MatrixXd& with_motions,
                        Eigen::Ref<Eigen::MatrixXd> covariance);

  const Problem& problem_;
  const State& state_;
  std::vector<Part> parts_;
  std::vector<int> part_of_pose_, part_of_point_;  // -1: nothing to do
};

}  // namespace collinea::bundle
