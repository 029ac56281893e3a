// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/surface/monoplot.h"
#include "collinea/surface/profile.h"

namespace collinea {

/// The surface that vertices are plotted on, in the coordinates of the map. Not for several threads at once.
struct PlottingSurface {
  HeightField heights;
  HeightSpan span;
  HeightSamples samples;
  bool has_sigmas = false;  ///< standard deviations lie beside it

  /// A GeoTIFF with its sigmas beside it. `span`: where it is known, so that not all of the raster is read. Errors:
  /// files; no heights.
  static Result<PlottingSurface> open(const std::filesystem::path& file, std::optional<HeightSpan> span = {});
};

}  // namespace collinea
