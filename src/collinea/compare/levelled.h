// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace collinea {

constexpr double kGrossSigmas = 5;  ///< larger errors are of another surface

/// Of a height with its standard deviation, at a place of the map.
struct PlacedError {
  double east_m = 0, north_m = 0;
  float error_m = 0, sigma_m = 0;
  int images = 0;  ///< that tell the height; 0: unknown
};

/// Takes off the plane that fits the errors best: what an orientation adds to the errors of a block is nearly one, and
/// standard deviations of matching do not tell of it. Fitted again without those that are gross for a first one. False
/// where too few of them, or all on a line, make no plane.
bool take_off_plane(std::vector<PlacedError>& errors);

}  // namespace collinea
