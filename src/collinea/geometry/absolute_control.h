// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace collinea {

/// A control point measured in a model: known on the ground in plan, in height or in both. Each side with its
/// covariance; one that is exact has zero, but not both.
struct AbsoluteControl {
  Eigen::Vector3d in_model = Eigen::Vector3d::Zero();
  Eigen::Matrix3d model_covariance = Eigen::Matrix3d::Zero();  ///< [units of the model, squared]
  Eigen::Vector3d in_ground = Eigen::Vector3d::Zero();         ///< what is not known is not looked at
  Eigen::Matrix3d ground_covariance = Eigen::Matrix3d::Identity();
  bool has_plan = true, has_height = true;

  [[nodiscard]] bool is_full() const { return has_plan && has_height; }
};

}  // namespace collinea
