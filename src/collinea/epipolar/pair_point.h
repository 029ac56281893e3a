// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace collinea {

/// A point measured in both images of a pair: undistorted image coordinates (X/Z, Y/Z) in cameras with x right, y down,
/// z forward, and the standard deviation of each coordinate in the same unit (a sigma in pixels over the principal
/// distance).
struct PairPoint {
  Eigen::Vector2d first, second;
  double sigma_first = 1, sigma_second = 1;
};

}  // namespace collinea
