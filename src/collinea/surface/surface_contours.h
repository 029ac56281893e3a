// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/base/run.h"

namespace collinea {

struct DrawnContours {
  double interval_m = 0;  ///< 0: none
  std::size_t lines = 0;
};

/// Contours of a surface model in a GeoTIFF as it is, not of a terrain: of a facade the lines of equal distance from
/// its plane. The interval shows the relief in twenty lines at most and no noise (`sigma_m` of a cell); they are drawn
/// of the blurred surface, of at most a million cells. Of a surface that is flat or empty there are none, and files of
/// that name are removed. Errors: reading, writing, kCancelled.
[[nodiscard]] Result<DrawnContours> draw_surface_contours(const std::filesystem::path& heights, double sigma_m,
                                                          const std::filesystem::path& geopackage,
                                                          const std::filesystem::path& dxf, const Run& run);

}  // namespace collinea
