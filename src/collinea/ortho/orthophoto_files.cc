// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include "collinea/ortho/orthophoto.h"
#include "collinea/raster/band_descriptions.h"

namespace collinea {

Result<OrthoSummary> make_orthophoto(const Block& block, const LocalFrame* frame, const HeightField& surface,
                                     const SeamGuides& guides, const PixelSource& pixels, double gsd_m,
                                     const OrthoFiles& files, const OrthoOptions& options, const Run& run) {
  std::optional<GeoTiffWriter<std::uint8_t>> image;
  std::optional<GeoTiffWriter<std::uint16_t>> source;
  const auto begin = [&](const MapGrid& grid) -> Result<> {
    GeoTiffWriter<std::uint8_t>::Options as_image;
    as_image.alpha = true, as_image.cloud_optimised = true;
    as_image.description = band::kOrthophoto;
    COLLINEA_TRY(image, GeoTiffWriter<std::uint8_t>::create(files.image, grid, 4, as_image));
    GeoTiffWriter<std::uint16_t>::Options as_source;
    as_source.nodata = 0;
    as_source.overviews = Overviews::kNearest;
    as_source.description = band::kOrthophotoSource;
    COLLINEA_TRY(source, GeoTiffWriter<std::uint16_t>::create(files.source, grid, 1, as_source));
    return {};
  };
  const auto take = [&](int column, int row, const OrthoTile& tile) {
    return image->write(column, row, tile.rgba).and_then([&] { return source->write(column, row, tile.source); });
  };
  COLLINEA_TRY(OrthoSummary summary, make_orthophoto(block, frame, surface, guides, pixels, gsd_m,
                                                     OrthoSink{begin, take, files.image}, options, run));
  auto finished = source->finish().and_then([&] { return image->finish(); });
  if (!finished) return tl::unexpected(std::move(finished).error());
  return summary;
}

}  // namespace collinea
