// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/geopackage.h"

#include <cpl_conv.h>
#include <gtest/gtest.h>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "collinea/base/test_folder.h"
#include "collinea/raster/gdal_access.h"

namespace collinea {
namespace {

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<VectorLayer> two_layers() {
  VectorLayer points{"points",
                     VectorKind::kPoint,
                     {{"name", VectorType::kText}, {"images", VectorType::kInteger}, {"sigma_h_m"}},
                     {{{{546812.25, 5338101.5, 352.125}}, {std::string("A, \"1\""), std::int64_t{7}, 0.015}},
                      {{{546812.25, 5338100.5, 352.0}}, {std::monostate(), std::int64_t{3}, std::nan("")}}}};
  VectorLayer site{"site", VectorKind::kPolygon, {{"area_m2"}}, {{{{0, 0, 1}, {10, 0, 1}, {10, 5, 1}}, {25.0}}}};
  VectorLayer way{"way", VectorKind::kLine, {}, {{{{0, 0, 1}, {3, 4, 1}}, {}}}};
  return {points, site, way};
}

TEST(GeoPackage, IsReadBackByGdalWithPositionsValuesAndCrs) {
  const TestFolder folder;
  set_up_gdal();
  OGRSpatialReferenceH utm = OSRNewSpatialReference(nullptr);
  ASSERT_EQ(OSRImportFromEPSG(utm, 32633), OGRERR_NONE);
  char* wkt = nullptr;
  OSRExportToWkt(utm, &wkt);
  const auto written = write_geopackage(folder / "p.gpkg", two_layers(), wkt);
  ASSERT_TRUE(written) << written.error().message;
  CPLFree(wkt);
  OSRRelease(utm);
  const GdalDataset file(
      GDALOpenEx((folder / "p.gpkg").c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  ASSERT_TRUE(file);
  ASSERT_EQ(GDALDatasetGetLayerCount(file.get()), 3);
  const OGRLayerH points = GDALDatasetGetLayerByName(file.get(), "points");
  EXPECT_EQ(std::string(OSRGetAuthorityCode(OGR_L_GetSpatialRef(points), nullptr)), "32633");
  OGRFeatureH feature = OGR_L_GetNextFeature(points);
  ASSERT_TRUE(feature);
  EXPECT_EQ(std::string(OGR_F_GetFieldAsString(feature, 0)), "A, \"1\"");
  EXPECT_EQ(OGR_F_GetFieldAsInteger64(feature, 1), 7);
  EXPECT_EQ(OGR_F_GetFieldAsDouble(feature, 2), 0.015);
  const OGRGeometryH geometry = OGR_F_GetGeometryRef(feature);
  EXPECT_EQ(OGR_G_GetX(geometry, 0), 546812.25);
  EXPECT_EQ(OGR_G_GetY(geometry, 0), 5338101.5);
  EXPECT_EQ(OGR_G_GetZ(geometry, 0), 352.125);
  OGR_F_Destroy(feature);
  feature = OGR_L_GetNextFeature(points);
  ASSERT_TRUE(feature);
  EXPECT_TRUE(OGR_F_IsFieldNull(feature, 0));
  EXPECT_TRUE(OGR_F_IsFieldNull(feature, 2));
  OGR_F_Destroy(feature);
  feature = OGR_L_GetNextFeature(GDALDatasetGetLayerByName(file.get(), "site"));
  ASSERT_TRUE(feature);
  EXPECT_EQ(OGR_G_Area(OGR_F_GetGeometryRef(feature)), 25);
  OGR_F_Destroy(feature);
  feature = OGR_L_GetNextFeature(GDALDatasetGetLayerByName(file.get(), "way"));
  ASSERT_TRUE(feature);
  EXPECT_EQ(OGR_G_Length(OGR_F_GetGeometryRef(feature)), 5);
  OGR_F_Destroy(feature);
}

// As QGIS looks for them: by the names of the table and of its geometry column, the one that is the default.
TEST(GeoPackage, StylesAreInTheTableThatQgisReads) {
  const TestFolder folder;
  set_up_gdal();
  std::vector<VectorLayer> layers = two_layers();
  layers[0].style = VectorStyle{{200, 40, 30}, 0.5, 2.5, 0, "na<me"};
  layers[0].description = "what it shows";
  layers[1].style = VectorStyle{{1, 2, 3}};
  for (const char* name : {"a.gpkg", "b.gpkg"}) ASSERT_TRUE(write_geopackage(folder / name, layers, ""));
  EXPECT_TRUE(bytes_of(folder / "a.gpkg") == bytes_of(folder / "b.gpkg"));
  const GdalDataset file(
      GDALOpenEx((folder / "a.gpkg").c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  ASSERT_TRUE(file);
  const auto rows = [&](const char* query) {
    std::vector<std::string> found;
    const OGRLayerH answer = GDALDatasetExecuteSQL(file.get(), query, nullptr, nullptr);
    while (OGRFeatureH row = answer ? OGR_L_GetNextFeature(answer) : nullptr) {
      found.emplace_back(OGR_F_GetFieldAsString(row, 0));
      OGR_F_Destroy(row);
    }
    if (answer) GDALDatasetReleaseResultSet(file.get(), answer);
    return found;
  };
  const auto styles = rows(
      "SELECT styleQML FROM layer_styles WHERE f_table_schema='' AND f_table_name='points' AND "
      "f_geometry_column='geom' "
      "AND useAsDefault=1");
  ASSERT_EQ(styles.size(), 1u);
  EXPECT_NE(styles[0].find("<prop k=\"color\" v=\"200,40,30,255\"/>"), std::string::npos) << styles[0];
  EXPECT_NE(styles[0].find("fieldName=\"na&lt;me\""), std::string::npos) << styles[0];
  EXPECT_EQ(rows("SELECT f_table_name FROM layer_styles ORDER BY id"), (std::vector<std::string>{"points", "site"}));
  EXPECT_EQ(rows("SELECT data_type FROM gpkg_contents WHERE table_name='layer_styles'"),
            std::vector<std::string>{"attributes"});
  EXPECT_EQ(rows("SELECT description FROM gpkg_contents WHERE table_name='points'"),
            std::vector<std::string>{"what it shows"});
}

TEST(GeoPackage, TheSameLayersGiveTheSameBytesAndReplaceWhatWasThere) {
  const TestFolder folder;
  ASSERT_TRUE(write_geopackage(folder / "a.gpkg", two_layers(), ""));
  ASSERT_TRUE(write_geopackage(folder / "b.gpkg", {}, ""));
  ASSERT_TRUE(write_geopackage(folder / "b.gpkg", two_layers(), ""));
  EXPECT_TRUE(bytes_of(folder / "a.gpkg") == bytes_of(folder / "b.gpkg"));
}

// A program that was killed leaves its part with SQLite's journal beside it; these shall not spoil the next file.
TEST(GeoPackage, HalfWrittenFilesOfAKilledProgramAreReplaced) {
  const TestFolder folder;
  std::ofstream(folder / "a.part.gpkg") << "half";
  std::ofstream(folder / "a.part.gpkg-journal") << "half";
  ASSERT_TRUE(write_geopackage(folder / "a.gpkg", two_layers(), ""));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.part.gpkg"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.part.gpkg-journal"));
}

TEST(GeoPackage, AFolderThatIsNotThereIsAnError) {
  const TestFolder folder;
  const auto written = write_geopackage(folder / "nowhere" / "a.gpkg", two_layers(), "");
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("cannot be written"), std::string::npos) << written.error().message;
}

// What a person may call a layer: letters of any script, signs, words of SQL.
TEST(GeoPackage, AnyNameOfALayerWorksOrIsRefused) {
  const TestFolder folder;
  std::vector<VectorLayer> layers;
  for (const char* name : {"D\u00e4cher (neu)", "a'b", "a\"b", "a]b[c", "select", "100 %_x", "x;y--", "\u5c4b\u6839",
                           "a.b", "rowid", " a ", "main.t", "layer_sqlite_x"}) {
    VectorLayer layer = two_layers()[0];
    layer.name = name;
    layer.style = VectorStyle{};
    layers.push_back(layer);
  }
  const auto written = write_geopackage(folder / "p.gpkg", layers, "");
  ASSERT_TRUE(written) << written.error().message;
  set_up_gdal();
  const GdalDataset file(
      GDALOpenEx((folder / "p.gpkg").c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  ASSERT_TRUE(file);
  for (const VectorLayer& layer : layers) {
    const OGRLayerH read = GDALDatasetGetLayerByName(file.get(), layer.name.c_str());
    ASSERT_TRUE(read) << layer.name;
    EXPECT_EQ(OGR_L_GetName(read), layer.name);
    EXPECT_EQ(OGR_L_GetFeatureCount(read, 1), 2) << layer.name;
    OGR_L_SetSpatialFilterRect(read, 546812, 5338101, 546813, 5338102);  // by its index
    EXPECT_EQ(OGR_L_GetFeatureCount(read, 1), 1) << layer.name;
  }
  for (const char* name : {"sqlite_x", "SQLITE_x", "gpkg_x", "rtree_x", "layer_styles", ""}) {
    VectorLayer layer = two_layers()[0];
    layer.name = name;
    const auto refused = write_geopackage(folder / "q.gpkg", {layer}, "");
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.error().code, Errc::kBadInput);
    EXPECT_NE(refused.error().message.find(name), std::string::npos);
  }
  VectorLayer one = two_layers()[0], other = one;
  one.name = "Roof", other.name = "rooF";
  EXPECT_FALSE(write_geopackage(folder / "q.gpkg", {one, other}, ""));
  EXPECT_FALSE(std::filesystem::exists(folder / "q.gpkg"));
}

}  // namespace
}  // namespace collinea
