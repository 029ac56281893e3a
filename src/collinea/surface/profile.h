// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/surface/internal/height_samples.h"

namespace collinea {

/// Heights along a line, of several surfaces side by side.
struct Profile {
  std::vector<double> distance_m;             ///< from its beginning, in plan
  std::vector<Eigen::Vector2d> positions;     ///< on the map
  std::vector<std::vector<HeightSample>> of;  ///< one list for each surface
};

/// Samples the surfaces along a line at its corners and at equal steps of at most `step_m` between them. Errors:
/// reading; a line of fewer than two points; a million steps and more.
[[nodiscard]] Result<Profile> profile_along(const std::vector<Eigen::Vector2d>& line, double step_m,
                                            std::vector<HeightSamples>& surfaces);

}  // namespace collinea
