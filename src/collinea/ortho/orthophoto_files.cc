// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <memory>
#include <mutex>
#include <optional>

#include "collinea/ortho/orthophoto.h"
#include "collinea/raster/band_descriptions.h"

namespace collinea {

namespace {

using ReadFloats = std::function<Result<FloatImage>(int column, int row, int width, int height)>;

Result<ReadFloats> open_floats(const std::filesystem::path& path, MapGrid& grid) {
  struct Shared {
    std::mutex mutex;
    GeoTiffReader reader;
  };
  COLLINEA_TRY(GeoTiffReader reader, GeoTiffReader::open(path));
  const auto shared = std::shared_ptr<Shared>(new Shared{{}, std::move(reader)});
  grid = shared->reader.grid();
  return [shared](int column, int row, int width, int height) -> Result<FloatImage> {
    const std::lock_guard lock(shared->mutex);
    return shared->reader.read_known(column, row, width, height);
  };
}

// That the standard deviations are of other cells than the heights.
Error not_of_one_model(const std::filesystem::path& path, const MapGrid& heights,
                       const std::filesystem::path& sigma_path, const MapGrid& sigmas) {
  return Error{
      Errc::kBadInput,
      fmt::format("{} ({} x {} cells of {} m from {:.3f} east, {:.3f} north) does not lie on {} ({} x {} cells of {} m "
                  "from {:.3f} east, {:.3f} north): the two are not of one surface model",
                  sigma_path.string(), sigmas.width, sigmas.height, sigmas.cell_m, sigmas.west_m, sigmas.north_m,
                  path.string(), heights.width, heights.height, heights.cell_m, heights.west_m, heights.north_m)};
}

}  // namespace

Result<HeightField> open_height_field(const std::filesystem::path& path, const std::filesystem::path& sigma_path) {
  HeightField field;
  COLLINEA_TRY(field.read, open_floats(path, field.grid));
  if (sigma_path.empty() || !std::filesystem::exists(sigma_path)) return field;
  MapGrid grid;
  COLLINEA_TRY(field.read_sigma, open_floats(sigma_path, grid));
  if (!same_cells(field.grid, grid)) return tl::unexpected(not_of_one_model(path, field.grid, sigma_path, grid));
  return field;
}

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
