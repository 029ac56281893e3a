// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "collinea/synthetic/internal/scene.h"

namespace collinea {

/// A piece of country to fly over: hills, fields, roads, houses and halls.
struct VillageOptions {
  Eigen::Vector2d low{-150, -150}, high{150, 150};              ///< corners of the terrain [m]
  double cell_m = 0.25;                                         ///< of the terrain grid
  double relief_m = 8;                                          ///< about the range of terrain heights over 200 m
  double building_area_m2 = 1400;                               ///< one building on so much land; 0: none
  Eigen::Vector2d built_low{-100, -100}, built_high{100, 100};  ///< buildings stand inside
  double sun_azimuth_deg = 155, sun_elevation_deg = 52;
  std::uint64_t seed = 1;
};

/// Heights are about 0 at the origin of the world. The same options give the same scene.
[[nodiscard]] Scene make_village(const VillageOptions& options);

/// A wall of bays and storeys along x with its front on the plane y = 0, seen from y < 0, and the pavement before it.
struct FacadeScene {
  double width_m = 24, storey_m = 3.5;
  int storeys = 3, bays = 8;
  double yard_m = 30;   ///< depth of the pavement before the wall
  double cell_m = 0.1;  ///< of the pavement's grid
  double sun_azimuth_deg = 205, sun_elevation_deg = 38;
  std::uint64_t seed = 1;
};
[[nodiscard]] Scene make_facade_scene(const FacadeScene& options);

}  // namespace collinea
