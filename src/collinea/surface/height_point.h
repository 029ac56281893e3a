// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace collinea {

/// A point of a surface.
struct HeightPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< east, north, height [m]
  double sigma_m = 0;                                  ///< of its height; 0: not known
};

}  // namespace collinea
