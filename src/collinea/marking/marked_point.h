// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/quality/joint_poses.h"

namespace collinea {

/// A point marked in an image: column and row with their covariance.
struct PointMark {
  std::size_t image = 0;  ///< index in JointPoses::images
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;  ///< [px^2]
};

/// What the other marks of its point say of a mark. Two values: column, row.
struct PointMarkTest {
  Eigen::Vector2d residual_px;  ///< measured minus computed
  Eigen::Vector2d
      redundancy;     ///< part of an error that shows in its own residual; not always in [0, 1]: poses correlate marks
  Eigen::Vector2d w;  ///< Baarda's test; NaN: nothing checks it
  Eigen::Vector2d detectable_px;  ///< error that is found with a power of 80 % at a level of 0.1 %; infinite: none
};

/// A point as its own marks give it.
struct MarkedPoint {
  Eigen::Vector3d position_in_world;
  Eigen::Matrix3d covariance;        ///< of marks, poses and cameras
  Eigen::MatrixXd gain;              ///< 3 x 2 n: by what errors of the marks, column and row, move it
  int redundancy = 0;                ///< 2 n - 3
  double sigma0 = 0;                 ///< root of the weighted squares over the redundancy
  std::vector<PointMarkTest> tests;  ///< parallel to the marks
};

/// One point, adjusted together with the poses and cameras of its images, which are observed as the adjustment of the
/// block left them: with B and J the derivatives of the pixels by point and by images, S = Sigma + J C J' and
///
///     G = (B' S^-1 B)^-1 B' S^-1,    dx = G (marks - computed),    covariance (B' S^-1 B)^-1
///
/// which is what the adjustment of the block with this point as one more tie point gives (of linear equations exactly:
/// sequential adjustment, as MarkedBlock). What the marks change in the poses is left to the next adjustment of the
/// block: residuals are those in the poses as they stand. Nothing with fewer than two marks, when rays are too parallel
/// to fix a depth, when they meet behind a camera, or when the iteration does not settle. `images`: their poses have
/// the covariance C; zero where they are exact.
[[nodiscard]] std::optional<MarkedPoint> marked_point(const Block& block, const JointPoses& images,
                                                      std::span<const PointMark> marks);

}  // namespace collinea
