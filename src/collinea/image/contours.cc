// SPDX-License-Identifier: Apache-2.0
#include "collinea/image/contours.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <gdal_alg.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <cstdio>
#include <system_error>

#include "collinea/image/gdal_access.h"

namespace collinea {
namespace {

constexpr double kNothing = -1e30;  // instead of NaN, which GDAL's contours do not leave out

// GDAL writes the time into GeoPackages; the same work is to give the same bytes.
class FixedDate {
 public:
  FixedDate() { CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z"); }
  ~FixedDate() { CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", nullptr); }
  FixedDate(const FixedDate&) = delete;
  FixedDate& operator=(const FixedDate&) = delete;
};

struct SrsReleaser {
  void operator()(void* srs) const { OSRRelease(srs); }
};

// A dataset of one layer that takes its name once it is whole.
class LineFile {
 public:
  Result<> create(const char* driver_name, const std::filesystem::path& path, const std::string& wkt, bool fields) {
    path_ = path;
    part_ = path.parent_path() / (path.stem().string() + ".part" + path.extension().string());
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
    const GDALDriverH driver = GDALGetDriverByName(driver_name);
    if (!driver) return fail(Errc::kUnsupported, std::string("this GDAL has no driver for ") + driver_name);
    const GdalErrors errors;
    dataset_.reset(GDALCreate(driver, part_.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
    if (!dataset_) return errors.error(Errc::kBadInput, path.string() + " cannot be written");
    std::unique_ptr<void, SrsReleaser> srs;
    if (fields && !wkt.empty()) srs.reset(OSRNewSpatialReference(wkt.c_str()));
    layer_ = GDALDatasetCreateLayer(dataset_.get(), "contours", srs.get(), wkbLineString25D, nullptr);
    if (layer_ && fields) {
      const OGRFieldDefnH height = OGR_Fld_Create("height_m", OFTReal);
      const OGRErr made = OGR_L_CreateField(layer_, height, TRUE);
      OGR_Fld_Destroy(height);
      if (made != OGRERR_NONE) layer_ = nullptr;
    }
    if (!layer_ || errors.any()) return errors.error(Errc::kBadInput, path.string() + " cannot be written");
    return {};
  }
  ~LineFile() {
    if (!dataset_) return;
    const GdalErrors muted;
    dataset_.reset();
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
  }
  LineFile() = default;
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  [[nodiscard]] OGRLayerH layer() const { return layer_; }
  Result<> finish() {
    {
      const GdalErrors errors;
      dataset_.reset();
      if (errors.any()) return errors.error(Errc::kBadInput, path_.string() + " cannot be written");
    }
    std::error_code failed;
    std::filesystem::rename(part_, path_, failed);
    if (failed) return fail(Errc::kBadInput, path_.string() + " cannot be written: " + failed.message());
    return {};
  }

 private:
  std::filesystem::path path_, part_;
  GdalDataset dataset_;
  OGRLayerH layer_ = nullptr;
};

Result<GdalDataset> in_memory(const FloatImage& heights_m, const MapGrid& grid) {
  const GdalErrors errors;
  GdalDataset raster(GDALCreate(GDALGetDriverByName("MEM"), "", grid.width, grid.height, 1, GDT_Float32, nullptr));
  if (!raster) return errors.error(Errc::kBadInput, "contours");
  double corner[] = {grid.west_m, grid.cell_m, 0, grid.north_m, 0, -grid.cell_m};
  GDALSetGeoTransform(raster.get(), corner);
  std::vector<float> line(std::size_t(grid.width));
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const float height_m = heights_m.at(x, y);
      line[std::size_t(x)] = std::isnan(height_m) ? float(kNothing) : height_m;
    }
    if (GDALRasterIO(GDALGetRasterBand(raster.get(), 1), GF_Write, 0, y, grid.width, 1, line.data(), grid.width, 1,
                     GDT_Float32, 0, 0) != CE_None)
      return errors.error(Errc::kBadInput, "contours");
  }
  return raster;
}

Result<> add_contours(void* raster, double interval_m, OGRLayerH layer, bool fields) {
  char** options = nullptr;
  char text[64];
  std::snprintf(text, sizeof text, "%.17g", interval_m);
  options = CSLSetNameValue(options, "LEVEL_INTERVAL", text);
  std::snprintf(text, sizeof text, "%.17g", double(float(kNothing)));
  options = CSLSetNameValue(options, "NODATA", text);
  if (fields) options = CSLSetNameValue(options, "ELEV_FIELD", "0");
  const GdalErrors errors;
  const bool begun = OGR_L_StartTransaction(layer) == OGRERR_NONE;
  const CPLErr verdict = GDALContourGenerateEx(GDALGetRasterBand(raster, 1), layer, options, nullptr, nullptr);
  const bool ended = !begun || OGR_L_CommitTransaction(layer) == OGRERR_NONE;
  CSLDestroy(options);
  if (verdict != CE_None || !ended || errors.any()) return errors.error(Errc::kBadInput, "contours");
  return {};
}

}  // namespace

Result<std::uint64_t> write_contours(const FloatImage& heights_m, const MapGrid& grid, double interval_m,
                                     const std::filesystem::path& geopackage, const std::filesystem::path& dxf) {
  COLLINEA_CHECK(interval_m > 0 && heights_m.width == grid.width && heights_m.height == grid.height);
  set_up_gdal();
  const FixedDate date;
  COLLINEA_TRY(const GdalDataset raster, in_memory(heights_m, grid));
  LineFile package, drawing;
  if (auto made = package.create("GPKG", geopackage, grid.wkt, true); !made) return tl::unexpected(made.error());
  if (auto made = drawing.create("DXF", dxf, grid.wkt, false); !made) return tl::unexpected(made.error());
  if (auto added = add_contours(raster.get(), interval_m, package.layer(), true); !added)
    return tl::unexpected(added.error());
  if (auto added = add_contours(raster.get(), interval_m, drawing.layer(), false); !added)
    return tl::unexpected(added.error());
  const auto lines = std::uint64_t(std::max<GIntBig>(0, OGR_L_GetFeatureCount(package.layer(), TRUE)));
  if (auto finished = package.finish(); !finished) return tl::unexpected(finished.error());
  if (auto finished = drawing.finish(); !finished) return tl::unexpected(finished.error());
  return lines;
}

}  // namespace collinea
