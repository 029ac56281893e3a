// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include "collinea/epipolar/relative_elements.h"
#include "collinea/geometry/absolute_orientation.h"
#include "collinea/jobs/internal/exterior_table.h"
#include "collinea/jobs/internal/pair_options.h"

namespace collinea {

/// The orientation of a pair as a table gives it.
struct GivenPair {
  std::array<UncertainPose, 2> poses;
  bool is_metric = true;
  Rigid3 second_from_first;              ///< translation of unit length
  Matrix5 covariance = Matrix5::Zero();  ///< of changed(), by those of the poses, taken as independent
  Eigen::Matrix<double, 6, 6> covariance_with_base = Eigen::Matrix<double, 6, 6>::Zero();  ///< of [changed(), base]
  double base = 1;  ///< distance of the projection centres

  /// Of the model whose frame is the left camera, with that base; without what the poses make uncertain.
  [[nodiscard]] AbsoluteOrientation ground_from_model() const;
};

/// A pose after a small change of one of its six parameters (UncertainPose::covariance).
[[nodiscard]] Rigid3 pose_after(const Rigid3& cam_from_world, int parameter, double step);

/// Of two poses. Nothing where both have one projection centre.
[[nodiscard]] std::optional<GivenPair> pair_of_poses(const UncertainPose& left, const UncertainPose& right);

/// The poses of both images in the table of the options, under the name of their file, that name without its end, left
/// and right, or as pair_film() names its images. Errors: the table; an image that is not in it; one position for both;
/// options that the table takes the place of.
[[nodiscard]] Result<GivenPair> read_given_pair(const std::filesystem::path& left, const std::filesystem::path& right,
                                                const PairChainOptions& options);

}  // namespace collinea
