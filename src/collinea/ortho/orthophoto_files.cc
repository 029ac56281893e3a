// SPDX-License-Identifier: Apache-2.0
#include <optional>

#include "collinea/ortho/orthophoto.h"
#include "collinea/raster/band_descriptions.h"

namespace collinea {

Result<OrthoSummary> make_orthophoto(const Block& block, const LocalFrame* frame, const HeightField& surface,
                                     const SeamGuides& guides, const PixelSource& pixels, double gsd_m,
                                     const OrthoFiles& files, const OrthoOptions& options, const Run& run) {
  std::optional<GeoTiffWriter<std::uint8_t>> picture;
  std::optional<GeoTiffWriter<std::uint16_t>> source;
  const auto begin = [&](const MapGrid& grid) -> Result<> {
    GeoTiffWriter<std::uint8_t>::Options as_picture;
    as_picture.alpha = true, as_picture.cloud_optimised = true;
    as_picture.description = band::kOrthophoto;
    COLLINEA_TRY(picture, GeoTiffWriter<std::uint8_t>::create(files.picture, grid, 4, as_picture));
    GeoTiffWriter<std::uint16_t>::Options as_source;
    as_source.nodata = 0;
    as_source.description = band::kOrthophotoSource;
    COLLINEA_TRY(source, GeoTiffWriter<std::uint16_t>::create(files.source, grid, 1, as_source));
    return {};
  };
  const auto take = [&](int column, int row, const OrthoTile& tile) {
    return picture->write(column, row, tile.rgba).and_then([&] { return source->write(column, row, tile.source); });
  };
  COLLINEA_TRY(OrthoSummary summary, make_orthophoto(block, frame, surface, guides, pixels, gsd_m,
                                                     OrthoSink{begin, take, files.picture}, options, run));
  auto finished = source->finish().and_then([&] { return picture->finish(); });
  if (!finished) return tl::unexpected(std::move(finished).error());
  return summary;
}

}  // namespace collinea
