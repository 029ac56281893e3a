// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/geodetic_model.h"
#include "collinea/adjust/solved.h"
#include "collinea/quality/internal/covariance_of_images.h"

namespace collinea::bundle {

/// A point with its marks as rays of a problem, where it begins, and what is given for it.
struct MarkPoint {
  std::vector<Ray> rays;
  Eigen::Vector3d start;
  Eigen::Vector3d given = Eigen::Vector3d::Zero();
  Eigen::Matrix3d weight = Eigen::Matrix3d::Zero();  ///< of the given coordinates; 0: none
  bool takes_part = true;  ///< false: it is intersected from the images as the others leave them
};

/// A measurement on the ground between two of the points that take part, or of one that lies on a shape.
struct MarkLink {
  GeodeticObservation observation;
  std::size_t from = 0, to = 0;  ///< among the points that take part
  int auxiliary = -1;            ///< first of its own unknowns in MarkGround::auxiliaries; -1: none
  int shape = -1;                ///< index in MarkGround::shapes
};
/// Everything that was measured on the ground.
struct MarkGround {
  std::vector<MarkLink> links = {};
  std::vector<GeodeticShape> shapes = {};
  std::vector<double> auxiliaries = {};  ///< orientations of set-ups, and what describes shapes: where they begin
};

/// What the adjustment of marks leaves.
struct MarkSolution {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Matrix3d> cofactors;  ///< of each position
  Eigen::MatrixXd cofactor;                ///< of the positions of points that take part together, 3 rows each
  /// Of each ray, 2 rows, in the order of points and rays: marked minus adjusted in sigmas, the part of a blunder that
  /// shows in it, and its own standard deviation.
  Eigen::VectorXd residuals, redundancy, residual_sigmas;
  bool converged = false;
};

/// Adjusts points with rays in images whose unknowns have a covariance (see MarkedBlock). `step`: by how much all
/// reduced unknowns would move without the marks, from where `state` has them. `motion`: of a block that
/// nothing fixes, whose seven motions are unknowns, too. `ground`: by the sigmas of its observations. Nothing when
/// something is not determined: rays that do not meet, or too little given to place the block.
[[nodiscard]] std::optional<MarkSolution> solve_marks(const Problem& problem, const State& state,
                                                      std::span<const MarkPoint> points, CovarianceOfImages& covariance,
                                                      std::span<const double> step,
                                                      const std::optional<BlockMotion>& motion,
                                                      const MarkGround& ground = {});

}  // namespace collinea::bundle
