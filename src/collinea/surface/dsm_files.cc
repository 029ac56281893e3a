// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <utility>

#include "collinea/raster/band_descriptions.h"
#include "collinea/surface/dsm.h"

namespace collinea {
namespace {

// The rasters while they are written.
struct Writers {
  std::optional<GeoTiffWriter<float>> height, sigma, sigma_relative;
  std::optional<GeoTiffWriter<std::uint8_t>> state;
  std::optional<GeoTiffWriter<std::uint16_t>> count;
};

template <class T>
Result<> start(std::optional<GeoTiffWriter<T>>& writer, const std::filesystem::path& path, const MapGrid& grid,
               std::optional<double> nodata, FileText description, Overviews overviews = Overviews::kNone) {
  typename GeoTiffWriter<T>::Options options;
  options.nodata = nodata;
  options.description = description;
  options.overviews = overviews;
  COLLINEA_TRY(writer, GeoTiffWriter<T>::create(path, grid, 1, options));
  return {};
}

Result<> start_all(Writers& writers, const DsmFiles& files, const MapGrid& grid) {
  return start(writers.height, files.height, grid, double(kNoHeight), band::kSurfaceHeight)
      .and_then([&] {
        return start(writers.sigma, files.sigma, grid, double(kNoHeight), band::kHeightSigma, Overviews::kMean);
      })
      .and_then([&] {
        return start(writers.sigma_relative, files.sigma_relative, grid, double(kNoHeight), band::kRelativeHeightSigma);
      })
      .and_then([&] { return start(writers.state, files.state, grid, std::nullopt, band::kSurfaceState); })
      .and_then([&] { return start(writers.count, files.count, grid, std::nullopt, band::kPointCount); });
}

Result<> write_all(Writers& writers, int column, int row, const SurfaceTile& tile) {
  return writers.height->write(column, row, tile.height_m)
      .and_then([&] { return writers.sigma->write(column, row, tile.sigma_m); })
      .and_then([&] { return writers.sigma_relative->write(column, row, tile.sigma_relative_m); })
      .and_then([&] { return writers.state->write(column, row, tile.state); })
      .and_then([&] { return writers.count->write(column, row, tile.count); });
}

}  // namespace

Result<DsmSummary> build_dsm(const SurfaceCloud& cloud, const DsmFiles& files, const std::filesystem::path& scratch,
                             const DsmOptions& options, const Run& run) {
  Writers writers;
  const SurfaceSink sink{
      [&](const MapGrid& grid) { return start_all(writers, files, grid); },
      [&](int column, int row, const SurfaceTile& tile) { return write_all(writers, column, row, tile); }};
  COLLINEA_TRY(const DsmSummary summary, build_dsm(cloud, sink, scratch, options, run));
  // The height comes last: where it is, all are.
  auto finished = writers.sigma->finish()
                      .and_then([&] { return writers.sigma_relative->finish(); })
                      .and_then([&] { return writers.state->finish(); })
                      .and_then([&] { return writers.count->finish(); })
                      .and_then([&] { return writers.height->finish(); });
  if (!finished) return tl::unexpected(std::move(finished).error());
  return summary;
}

}  // namespace collinea
