// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "collinea/raster/codec.h"
#include "collinea/raster/gdal_access.h"
#include "collinea/raster/geotiff.h"

namespace collinea {

bool same_cells(const MapGrid& a, const MapGrid& b) {
  constexpr double kRounding = 1e-3;  // [cells], all over the raster
  const auto apart = [&](double x, double y) { return std::abs(x - y) / a.cell_m; };
  return a.width == b.width && a.height == b.height && apart(a.west_m, b.west_m) < kRounding &&
         apart(a.north_m, b.north_m) < kRounding && apart(a.east_of(a.width), b.east_of(b.width)) < kRounding &&
         apart(a.north_of(a.height), b.north_of(b.height)) < kRounding;
}

struct GeoTiffReader::State {
  std::filesystem::path path;
  MapGrid grid;
  int channels = 0;
  std::optional<double> nodata;
  GdalDataset dataset;

  Result<> read_description();
  Result<> check_blocks() const;
  template <class T>
  Result<Raster<T>> read(int column, int row, int width, int height, int out_width, int out_height) const;
};

// A block is what GDAL takes into memory at once; a file may state any size of it.
Result<> GeoTiffReader::State::check_blocks() const {
  constexpr std::uint64_t kHarmless_bytes = 64 << 20;
  std::error_code unknown;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, unknown);
  for (int i = 1; i <= channels; ++i) {
    const GDALRasterBandH band = GDALGetRasterBand(dataset.get(), i);
    int width = 0, height = 0;
    GDALGetBlockSize(band, &width, &height);
    const std::uint64_t bytes = std::uint64_t(width) * std::uint64_t(height) *
                                std::uint64_t(GDALGetDataTypeSizeBytes(GDALGetRasterDataType(band)));
    if (bytes > kHarmless_bytes && bytes / kTiffPxPerByte > file_bytes)
      return fail(Errc::kBadFormat, path.string() + " is damaged: blocks of " + std::to_string(width) + " x " +
                                        std::to_string(height) + " pixels cannot be in " + std::to_string(file_bytes) +
                                        " bytes");
  }
  return {};
}

Result<> GeoTiffReader::State::read_description() {
  void* file = dataset.get();
  grid.width = GDALGetRasterXSize(file);
  grid.height = GDALGetRasterYSize(file);
  channels = GDALGetRasterCount(file);
  if (channels < 1) return fail(Errc::kBadFormat, path.string() + " holds no raster");
  COLLINEA_TRY(check_blocks());
  if (const char* wkt = GDALGetProjectionRef(file)) grid.wkt = wkt;
  int has_nodata = 0;
  const double value = GDALGetRasterNoDataValue(GDALGetRasterBand(file, 1), &has_nodata);
  if (has_nodata) nodata = value;

  double corner[6];
  if (GDALGetGeoTransform(file, corner) != CE_None) {
    grid.north_m = grid.height;  // not georeferenced: cells of 1, lower-left corner at (0, 0)
    return {};
  }
  if (!std::isfinite(corner[0]) || !std::isfinite(corner[3]) || !std::isfinite(corner[1]))
    return fail(Errc::kBadFormat, path.string() + " is damaged: it lies nowhere on the map");
  if (corner[2] != 0 || corner[4] != 0 || !(corner[1] > 0) || std::abs(corner[1] + corner[5]) > 1e-6 * corner[1])
    return fail(Errc::kUnsupported,
                path.string() + " is rotated or its cells are not square; a north-up raster is needed");
  grid.west_m = corner[0];
  grid.north_m = corner[3];
  grid.cell_m = corner[1];
  return {};
}

template <class T>
Result<Raster<T>> GeoTiffReader::State::read(int column, int row, int width, int height, int out_width,
                                             int out_height) const {
  if (column < 0 || row < 0 || width < 1 || height < 1 || column > grid.width - width || row > grid.height - height)
    return fail(Errc::kBadInput, "a window outside " + path.string() + " was asked for");
  out_width = out_width > 0 ? out_width : width;
  out_height = out_height > 0 ? out_height : height;
  const GdalErrors errors;
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  how.eResampleAlg = GRIORA_Average;
  const GSpacing pixel = GSpacing(sizeof(T)) * channels;
  try {
    Raster<T> raster(out_width, out_height, channels);
    const CPLErr verdict =
        GDALDatasetRasterIOEx(dataset.get(), GF_Read, column, row, width, height, raster.data.data(), out_width,
                              out_height, gdal_type<T>(), channels, nullptr, pixel, pixel * out_width, sizeof(T), &how);
    if (verdict != CE_None || errors.any()) return errors.error(Errc::kBadFormat, "reading " + path.string());
    return raster;
  } catch (const std::bad_alloc&) {
    return fail(Errc::kUnsupported, "reading " + path.string() + ": not enough memory for this window");
  }
}

Result<GeoTiffReader> GeoTiffReader::open(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return fail(Errc::kNotFound, path.string() + ": no such file");
  set_up_gdal();
  GeoTiffReader reader;
  reader.state_ = std::make_unique<State>();
  reader.state_->path = path;
  const GdalErrors errors;
  // Drivers of raw rasters take a file's word for its width, and memory for a row of it.
  const char* const drivers[] = {"GTiff", nullptr};
  reader.state_->dataset.reset(
      GDALOpenEx(path.c_str(), GDAL_OF_READONLY | GDAL_OF_RASTER | GDAL_OF_VERBOSE_ERROR, drivers, nullptr, nullptr));
  if (!reader.state_->dataset)
    return errors.error(Errc::kBadFormat,
                        "reading " + path.string() + " as GeoTIFF (convert rasters of other formats)");
  if (const GDALRasterBandH band = GDALGetRasterBand(reader.state_->dataset.get(), 1);
      band && GDALGetRasterDataType(band) != GDT_Byte && GDALGetOverviewCount(band) > 0) {
    const char* const itself[] = {"OVERVIEW_LEVEL=NONE", nullptr};
    reader.state_->dataset.reset(
        GDALOpenEx(path.c_str(), GDAL_OF_READONLY | GDAL_OF_RASTER | GDAL_OF_VERBOSE_ERROR, drivers, itself, nullptr));
    if (!reader.state_->dataset) return errors.error(Errc::kBadFormat, "reading " + path.string());
  }
  if (Result<> verdict = reader.state_->read_description(); !verdict) return tl::unexpected(std::move(verdict).error());
  return reader;
}

const MapGrid& GeoTiffReader::grid() const { return state_->grid; }
int GeoTiffReader::channels() const { return state_->channels; }
std::optional<double> GeoTiffReader::nodata() const { return state_->nodata; }

Result<Raster<float>> GeoTiffReader::read_float(int column, int row, int width, int height, int out_width,
                                                int out_height) const {
  return state_->read<float>(column, row, width, height, out_width, out_height);
}

Result<Raster<float>> GeoTiffReader::read_known(int column, int row, int width, int height, int out_width,
                                                int out_height) const {
  COLLINEA_TRY(FloatImage values, read_float(column, row, width, height, out_width, out_height));
  if (state_->nodata)
    std::replace(values.data.begin(), values.data.end(), float(*state_->nodata),
                 std::numeric_limits<float>::quiet_NaN());
  return values;
}

Result<Raster<std::uint8_t>> GeoTiffReader::read_byte(int column, int row, int width, int height, int out_width,
                                                      int out_height) const {
  return state_->read<std::uint8_t>(column, row, width, height, out_width, out_height);
}

GeoTiffReader::GeoTiffReader() = default;
GeoTiffReader::GeoTiffReader(GeoTiffReader&&) noexcept = default;
GeoTiffReader& GeoTiffReader::operator=(GeoTiffReader&&) noexcept = default;
GeoTiffReader::~GeoTiffReader() = default;

}  // namespace collinea
