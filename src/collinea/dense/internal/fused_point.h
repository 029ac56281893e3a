// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace collinea {

/// A point of the surface on which several depth maps agree.
struct FusedPoint {
  Eigen::Vector3d position_in_world;  ///< [m, or the unit of the gauge]
  Eigen::Vector3f normal_in_world;    ///< unit length, towards the cameras
  std::array<std::uint8_t, 3> colour{};
  float sigma = 0;          ///< along the ray of the image it is written for [as position]; poses taken as exact
  std::uint8_t images = 0;  ///< whose depth maps agree
};

}  // namespace collinea
