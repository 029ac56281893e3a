// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/marking/local_poses.h"

namespace collinea {

/// A point marked in an image: column and row with their covariance.
struct PointMark {
  std::size_t image = 0;  ///< index in LocalPoses::images
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
  Eigen::Matrix3d covariance;        ///< of marks and poses
  int redundancy = 0;                ///< 2 n - 3
  double sigma0 = 0;                 ///< root of the weighted squares over the redundancy
  std::vector<PointMarkTest> tests;  ///< parallel to the marks
};

/// The least-squares intersection of the marks of one point, the poses being what the adjustment of the block made
/// them, with their joint covariance: residuals e have the covariance Sigma + J C J'. What a mark would change in the
/// poses is left to the next adjustment. Nothing with fewer than two marks, when rays are too parallel to fix a depth,
/// or when they meet behind a camera.
[[nodiscard]] std::optional<MarkedPoint> marked_point(const Block& block, const LocalPoses& local,
                                                      std::span<const PointMark> marks);

}  // namespace collinea
