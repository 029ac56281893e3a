// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace collinea {

constexpr double kGrossSigmas = 5;     ///< larger errors are of another surface
constexpr double kBoundSigmas = 1.96;  ///< hold 95 % of normal errors

/// The error of a height with its standard deviation, at a position on the map.
struct LocatedError {
  double east_m = 0, north_m = 0;
  float error_m = 0, sigma_m = 0;
  int images = 0;  ///< that tell the height; 0: unknown
};

/// Takes off the plane that fits the errors best: what an orientation adds to the errors of a block is nearly one, and
/// standard deviations of matching do not tell of it. Gross errors do not move it, a fifth of them on one side neither;
/// and sigmas below their median weigh no more than that, since they are what is judged. False, and nothing is taken
/// off, where too few errors, or all on a line, make no plane.
[[nodiscard]] bool take_off_plane(std::vector<LocatedError>& errors);

}  // namespace collinea
