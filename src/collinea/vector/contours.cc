// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/contours.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <gdal_alg.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "collinea/vector/internal/vector_file.h"

namespace collinea {
namespace {

constexpr double kNothing = -1e30;  // instead of NaN, which GDAL's contours do not leave out

// The layer of the lines; in a format with fields it has the height and the CRS.
Result<OGRLayerH> line_layer(const VectorFile& file, const std::string& wkt, bool fields) {
  const GdalErrors errors;
  const GdalSrs srs(fields && !wkt.empty() ? OSRNewSpatialReference(wkt.c_str()) : nullptr);
  OGRLayerH layer = GDALDatasetCreateLayer(file.dataset(), "contours", srs.get(), wkbLineString25D, nullptr);
  if (layer && fields) {
    const OGRFieldDefnH height = OGR_Fld_Create("height_m", OFTReal);
    const OGRErr made = OGR_L_CreateField(layer, height, TRUE);
    OGR_Fld_Destroy(height);
    if (made != OGRERR_NONE) layer = nullptr;
  }
  if (!layer || errors.any()) return file.not_written(errors);
  return layer;
}

// The heights, which must outlive it, as a raster.
Result<GdalDataset> raster_over(FloatImage& heights_m, const MapGrid& grid) {
  const GdalErrors errors;
  GdalDataset raster(GDALCreate(GDALGetDriverByName("MEM"), "", grid.width, grid.height, 0, GDT_Float32, nullptr));
  if (!raster) return errors.error(Errc::kBadInput, "contours");
  double corner[] = {grid.west_m, grid.cell_m, 0, grid.north_m, 0, -grid.cell_m};
  GDALSetGeoTransform(raster.get(), corner);
  std::replace_if(
      heights_m.data.begin(), heights_m.data.end(), [](float height_m) { return std::isnan(height_m); },
      float(kNothing));
  char text[64] = {};
  CPLPrintPointer(text, heights_m.data.data(), sizeof text);
  char** options = CSLSetNameValue(nullptr, "DATAPOINTER", text);
  const CPLErr verdict = GDALAddBand(raster.get(), GDT_Float32, options);
  CSLDestroy(options);
  if (verdict != CE_None) return errors.error(Errc::kBadInput, "contours");
  return raster;
}

// All lines of a raster as a layer in memory, with their heights.
Result<GdalDataset> lines_of(void* raster, double interval_m) {
  const GdalErrors errors;
  GdalDataset lines(GDALCreate(GDALGetDriverByName("Memory"), "", 0, 0, 0, GDT_Unknown, nullptr));
  if (!lines) return errors.error(Errc::kBadInput, "contours");
  const OGRLayerH layer = GDALDatasetCreateLayer(lines.get(), "contours", nullptr, wkbLineString25D, nullptr);
  char** options = nullptr;
  char text[64];
  std::snprintf(text, sizeof text, "%.17g", interval_m);
  options = CSLSetNameValue(options, "LEVEL_INTERVAL", text);
  std::snprintf(text, sizeof text, "%.17g", double(float(kNothing)));
  options = CSLSetNameValue(options, "NODATA", text);
  const CPLErr verdict = GDALContourGenerateEx(GDALGetRasterBand(raster, 1), layer, options, nullptr, nullptr);
  CSLDestroy(options);
  if (verdict != CE_None || errors.any()) return errors.error(Errc::kBadInput, "contours");
  return lines;
}

Result<> add_line(OGRLayerH layer, OGRGeometryH line) {
  const GdalErrors errors;
  const OGRFeatureH feature = OGR_F_Create(OGR_L_GetLayerDefn(layer));
  if (const int field = OGR_F_GetFieldIndex(feature, "height_m"); field >= 0)
    OGR_F_SetFieldDouble(feature, field, OGR_G_GetZ(line, 0));
  const bool added =
      OGR_F_SetGeometry(feature, line) == OGRERR_NONE && OGR_L_CreateFeature(layer, feature) == OGRERR_NONE;
  OGR_F_Destroy(feature);
  if (!added || errors.any()) return errors.error(Errc::kBadInput, "contours");
  return {};
}

struct FeatureDestroyer {
  void operator()(void* feature) const { OGR_F_Destroy(feature); }
};

// Returns how many there were.
Result<std::uint64_t> copy_lines(OGRLayerH from, double shortest_m, OGRLayerH package, OGRLayerH drawing) {
  std::uint64_t count = 0;
  OGR_L_ResetReading(from);
  const bool begun = OGR_L_StartTransaction(package) == OGRERR_NONE;
  for (;;) {
    const std::unique_ptr<void, FeatureDestroyer> feature(OGR_L_GetNextFeature(from));
    if (!feature) break;
    const OGRGeometryH line = OGR_F_GetGeometryRef(feature.get());
    if (!line || OGR_G_Length(line) < shortest_m) continue;
    ++count;
    for (const OGRLayerH layer : {package, drawing}) COLLINEA_TRY(add_line(layer, line));
  }
  if (begun && OGR_L_CommitTransaction(package) != OGRERR_NONE) return fail(Errc::kBadInput, "contours: not written");
  return count;
}

}  // namespace

Result<std::uint64_t> write_contours(FloatImage heights_m, const MapGrid& grid, double interval_m, double shortest_m,
                                     const std::filesystem::path& geopackage, const std::filesystem::path& dxf) {
  COLLINEA_CHECK(interval_m > 0 && heights_m.width == grid.width && heights_m.height == grid.height);
  set_up_gdal();
  const FixedDate date;
  COLLINEA_TRY(const GdalDataset raster, raster_over(heights_m, grid));
  VectorFile package, drawing;
  COLLINEA_TRY(package.create("GPKG", geopackage));
  COLLINEA_TRY(drawing.create("DXF", dxf));
  COLLINEA_TRY(const OGRLayerH in_package, line_layer(package, grid.wkt, true));
  COLLINEA_TRY(const OGRLayerH in_drawing, line_layer(drawing, grid.wkt, false));
  COLLINEA_TRY(const GdalDataset all, lines_of(raster.get(), interval_m));
  COLLINEA_TRY(const std::uint64_t lines,
               copy_lines(GDALDatasetGetLayer(all.get(), 0), shortest_m, in_package, in_drawing));
  COLLINEA_TRY(package.finish());
  COLLINEA_TRY(drawing.finish());
  return lines;
}

}  // namespace collinea
