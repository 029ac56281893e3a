// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace collinea {

/// A point of a dense cloud as files hold it: in map coordinates, or in the block's world frame when it is not
/// georeferenced.
struct CloudPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();    ///< unit length, towards the cameras; zero: unknown
  std::array<std::uint8_t, 3> colour{};                ///< red, green, blue
  float sigma_m = 0;                                   ///< standard deviation along the viewing direction; 0: unknown
  std::uint8_t images = 0;                             ///< how many images agree on it
  std::uint8_t classification = 0;                     ///< ASPRS: 0 never classified, 2 ground, ...
};

}  // namespace collinea
