// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace collinea {

/// How well a place is known from images and cameras as they came out, by rays without error of their own: what
/// everything that is measured in the adjusted images has in common with what lies around it.
struct PlacePrecision {
  Eigen::Vector3d position_in_world;
  Eigen::Matrix3d covariance_m2;  ///< by the given sigmas
};

}  // namespace collinea
