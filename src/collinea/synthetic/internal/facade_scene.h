// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "collinea/synthetic/internal/scene.h"

namespace collinea {

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
