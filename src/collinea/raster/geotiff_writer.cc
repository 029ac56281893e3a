// SPDX-License-Identifier: Apache-2.0
#include <cpl_string.h>

#include "collinea/raster/gdal_access.h"
#include "collinea/raster/geotiff.h"

namespace collinea {
namespace {

/// Options in GDAL's way: NAME=VALUE.
class NameValues {
 public:
  NameValues() = default;
  ~NameValues() { CSLDestroy(list_); }
  NameValues(const NameValues&) = delete;
  NameValues& operator=(const NameValues&) = delete;
  void set(const char* name, const std::string& value) { list_ = CSLSetNameValue(list_, name, value.c_str()); }
  char** list() const { return list_; }

 private:
  char** list_ = nullptr;
};

int block_size(const MapGrid& grid) { return std::max(grid.width, grid.height) > 2048 ? 512 : 256; }

std::filesystem::path beside(const std::filesystem::path& path, const char* ending) {
  std::filesystem::path other = path;
  other += ending;
  return other;
}

template <class T, class Options>
void describe_layout(NameValues& values, const MapGrid& grid, int channels, const Options& options) {
  values.set("TILED", "YES");
  values.set("BLOCKXSIZE", std::to_string(block_size(grid)));
  values.set("BLOCKYSIZE", std::to_string(block_size(grid)));
  values.set("BIGTIFF", "IF_SAFER");
  values.set("INTERLEAVE", "PIXEL");
  values.set("SPARSE_OK", "TRUE");
  if (options.cloud_optimised) {
    values.set("COMPRESS", "ZSTD");  // read once and thrown away
    values.set("ZSTD_LEVEL", "1");
  } else {
    values.set("COMPRESS", "DEFLATE");
    values.set("ZLEVEL", "6");
  }
  values.set("PREDICTOR", std::is_floating_point_v<T> ? "3" : "2");
  const int colours = channels - (options.alpha ? 1 : 0);
  values.set("PHOTOMETRIC", colours == 3 && !std::is_floating_point_v<T> ? "RGB" : "MINISBLACK");
  if (options.alpha) values.set("ALPHA", "YES");
}

}  // namespace

template <class T>
struct GeoTiffWriter<T>::State {
  std::filesystem::path path, part;
  MapGrid grid;
  int channels = 1;
  Options options;
  GdalDataset dataset;

  ~State() {
    if (!dataset) return;
    const GdalErrors muted;
    dataset.reset();
    remove(part);
  }
  static void remove(const std::filesystem::path& file) {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
  }
  bool on_block_borders(int column, int row, const Raster<T>& window) const {
    const int block = block_size(grid);
    return column % block == 0 && row % block == 0 &&
           (window.width % block == 0 || column + window.width == grid.width) &&
           (window.height % block == 0 || row + window.height == grid.height);
  }
  bool describe_location() {
    void* file = dataset.get();
    double corner[] = {grid.west_m, grid.cell_m, 0, grid.north_m, 0, -grid.cell_m};
    if (GDALSetGeoTransform(file, corner) != CE_None) return false;
    if (!grid.wkt.empty() && GDALSetProjection(file, grid.wkt.c_str()) != CE_None) return false;
    for (int c = 1; options.nodata && c <= channels; ++c)
      if (GDALSetRasterNoDataValue(GDALGetRasterBand(file, c), *options.nodata) != CE_None) return false;
    return options.description.empty() ||
           GDALSetMetadataItem(file, "TIFFTAG_IMAGEDESCRIPTION", options.description.c_str(), nullptr) == CE_None;
  }
  Result<> copy_cloud_optimised(const std::filesystem::path& to) const;
  Result<> add_overviews() const;
};

template <class T>
Result<> GeoTiffWriter<T>::State::add_overviews() const {
  constexpr int kSmallest = 512;
  std::vector<int> factors;
  for (int factor = 2; std::max(grid.width, grid.height) / (factor / 2) > kSmallest; factor *= 2)
    factors.push_back(factor);
  if (factors.empty()) return {};
  const GdalErrors errors;
  const GdalDataset file(GDALOpen(part.c_str(), GA_Update));
  CPLSetThreadLocalConfigOption("ZLEVEL_OVERVIEW", "1");  // 1 % larger in a third less of the time
  const char* const how = options.overviews == Overviews::kNearest ? "NEAREST" : "AVERAGE";
  const bool made = file && GDALBuildOverviews(file.get(), how, int(factors.size()), factors.data(), 0, nullptr,
                                               nullptr, nullptr) == CE_None;
  CPLSetThreadLocalConfigOption("ZLEVEL_OVERVIEW", nullptr);  // other files of this thread are as ever
  if (!made) return errors.error(Errc::kBadInput, path.string() + " cannot be written");
  return {};
}

template <class T>
Result<> GeoTiffWriter<T>::State::copy_cloud_optimised(const std::filesystem::path& to) const {
  const GdalErrors errors;
  const GdalDataset source(GDALOpen(part.c_str(), GA_ReadOnly));
  if (!source) return errors.error(Errc::kBadInput, path.string() + " cannot be written");
  NameValues values;
  values.set("COMPRESS", "DEFLATE");
  values.set("LEVEL", "6");
  values.set("PREDICTOR", "YES");
  values.set("BLOCKSIZE", "512");
  values.set("BIGTIFF", "IF_SAFER");
  values.set("OVERVIEW_RESAMPLING", "AVERAGE");
  values.set("OVERVIEWS", "IGNORE_EXISTING");
  values.set("SPARSE_OK", "YES");
  values.set("NUM_THREADS", std::to_string(std::max(1, options.threads)));
  const GDALDriverH driver = GDALGetDriverByName("COG");
  if (!driver) return fail(Errc::kUnsupported, "this GDAL has no driver for cloud-optimised GeoTIFF");
  GdalDataset copy(GDALCreateCopy(driver, to.c_str(), source.get(), FALSE, values.list(), nullptr, nullptr));
  const bool made = copy != nullptr;
  copy.reset();
  if (!made || errors.any()) return errors.error(Errc::kBadInput, path.string() + " cannot be written");
  return {};
}

template <class T>
Result<GeoTiffWriter<T>> GeoTiffWriter<T>::create(const std::filesystem::path& path, const MapGrid& grid, int channels,
                                                  const Options& options) {
  if (grid.width < 1 || grid.height < 1 || !(grid.cell_m > 0))
    return fail(Errc::kBadInput, path.string() + ": a raster of " + std::to_string(grid.width) + " x " +
                                     std::to_string(grid.height) + " cells cannot be written");
  COLLINEA_CHECK(channels >= 1 && channels > int(options.alpha));
  set_up_gdal();
  GeoTiffWriter writer;
  writer.state_ = std::make_unique<State>();
  State& state = *writer.state_;
  state.path = path;
  state.part = beside(path, ".part");
  state.grid = grid;
  state.channels = channels;
  state.options = options;
  NameValues values;
  describe_layout<T>(values, grid, channels, options);
  const GdalErrors errors;
  state.dataset.reset(GDALCreate(GDALGetDriverByName("GTiff"), state.part.c_str(), grid.width, grid.height, channels,
                                 gdal_type<T>(), values.list()));
  if (!state.dataset || !state.describe_location() || errors.any())
    return errors.error(Errc::kBadInput, path.string() + " cannot be written");
  return writer;
}

template <class T>
Result<> GeoTiffWriter<T>::write(int column, int row, const Raster<T>& window) {
  State& state = *state_;
  COLLINEA_CHECK(state.dataset && window.channels == state.channels && !window.empty());
  COLLINEA_CHECK(column >= 0 && row >= 0 && column + window.width <= state.grid.width &&
                 row + window.height <= state.grid.height);
  const GdalErrors errors;
  const auto pixel = GSpacing(sizeof(T)) * state.channels;
  const CPLErr verdict =
      GDALDatasetRasterIOEx(state.dataset.get(), GF_Write, column, row, window.width, window.height,
                            const_cast<T*>(window.data.data()), window.width, window.height, gdal_type<T>(),
                            state.channels, nullptr, pixel, pixel * window.width, sizeof(T), nullptr);
  // Whole blocks go to the file at once and in order: what else is in GDAL's cache must not change the file.
  if (verdict == CE_None && state.on_block_borders(column, row, window)) GDALFlushCache(state.dataset.get());
  if (verdict != CE_None || errors.any())
    return errors.error(Errc::kBadInput, state.path.string() + " cannot be written");
  return {};
}

template <class T>
Result<> GeoTiffWriter<T>::finish() {
  State& state = *state_;
  COLLINEA_CHECK(state.dataset != nullptr);
  {
    const GdalErrors errors;
    GDALFlushCache(state.dataset.get());
    state.dataset.reset();
    if (errors.any()) {
      State::remove(state.part);
      return errors.error(Errc::kBadInput, state.path.string() + " cannot be written");
    }
  }
  std::filesystem::path ready = state.part;
  if (state.options.overviews != Overviews::kNone) {
    const Result<> added = state.add_overviews();
    if (!added) {
      State::remove(state.part);
      return added;
    }
  }
  if (state.options.cloud_optimised) {
    ready = beside(state.path, ".cog.part");
    const Result<> copied = state.copy_cloud_optimised(ready);
    State::remove(state.part);
    if (!copied) {
      State::remove(ready);
      return copied;
    }
  }
  std::error_code error;
  std::filesystem::rename(ready, state.path, error);
  if (!error) return {};
  State::remove(ready);
  return fail(Errc::kBadInput, state.path.string() + " cannot be written: " + error.message());
}

template <class T>
GeoTiffWriter<T>::GeoTiffWriter() = default;
template <class T>
GeoTiffWriter<T>::GeoTiffWriter(GeoTiffWriter&&) noexcept = default;
template <class T>
GeoTiffWriter<T>& GeoTiffWriter<T>::operator=(GeoTiffWriter&&) noexcept = default;
template <class T>
GeoTiffWriter<T>::~GeoTiffWriter() = default;

template class GeoTiffWriter<float>;
template class GeoTiffWriter<std::uint8_t>;
template class GeoTiffWriter<std::uint16_t>;

}  // namespace collinea
