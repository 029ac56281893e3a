// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/plotting_surface.h"

namespace collinea {

Result<PlottingSurface> PlottingSurface::open(const std::filesystem::path& file, std::optional<HeightSpan> span) {
  COLLINEA_TRY(HeightField heights, open_height_field(file));
  if (!span) {
    COLLINEA_TRY(span, height_span(heights, {}));
  }
  const SurfaceFiles files = with_sigmas_beside(file);
  COLLINEA_TRY(HeightSamples samples, HeightSamples::open(files, 0));
  return PlottingSurface{std::move(heights), *span, std::move(samples), files.sigma.has_value()};
}

}  // namespace collinea
