// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/vector_areas.h"

#include <gtest/gtest.h>
#include <ogr_srs_api.h>

#include <cpl_conv.h>

#include <fstream>
#include <sstream>

#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/raster/gdal_access.h"
#include "collinea/vector/geopackage.h"

namespace collinea {
namespace {

std::string wkt_of(int epsg) {
  set_up_gdal();
  OGRSpatialReferenceH srs = OSRNewSpatialReference(nullptr);
  OSRImportFromEPSG(srs, epsg);
  char* wkt = nullptr;
  OSRExportToWkt(srs, &wkt);
  std::string text = wkt;
  CPLFree(wkt);
  OSRRelease(srs);
  return text;
}

const std::vector<Eigen::Vector3d> kSquare = {
    {500'000.1, 10.7, 0}, {500'000.1, 20, 0}, {500'010, 20, 0}, {500'010, 10.7, 0}};
const std::vector<Eigen::Vector3d> kHole = {{500'002, 12, 0}, {500'003, 12, 0}, {500'003, 13, 0}};

VectorLayer layer(std::vector<VectorRow> rows) {
  return {"seamlines", VectorKind::kPolygon, {{"photo", VectorType::kText}}, std::move(rows), true};
}

std::string message_of(const Result<std::vector<NamedArea>>& areas) {
  return areas ? std::string("none") : areas.error().message;
}

TEST(ReadAreas, GivesBackWhatWasWrittenToTheLastBit) {
  const TestFolder folder;
  const std::string utm = wkt_of(32633);
  ASSERT_TRUE(write_geopackage(
      folder / "a.gpkg", {layer({{kSquare, {std::string("a.jpg")}, {kHole}}, {kHole, {std::string("b.jpg")}}})}, utm));
  const auto areas = read_areas(folder / "a.gpkg", "photo", utm);
  ASSERT_TRUE(areas) << areas.error().message;
  ASSERT_EQ(areas->size(), 2u);
  EXPECT_EQ(areas->at(0).name, "a.jpg");
  EXPECT_EQ(areas->at(1).name, "b.jpg");
  ASSERT_EQ(areas->at(0).rings.size(), 2u);
  for (std::size_t i = 0; i < kSquare.size(); ++i) EXPECT_EQ(areas->at(0).rings[0][i], kSquare[i].head<2>());
  for (std::size_t i = 0; i < kHole.size(); ++i) EXPECT_EQ(areas->at(0).rings[1][i], kHole[i].head<2>());
}

TEST(ReadAreas, SaysWhatIsWrong) {
  const TestFolder folder;
  const std::string utm = wkt_of(32633), other = wkt_of(32634);
  const auto read = [&](const VectorLayer& written, const std::string& wkt) {
    EXPECT_TRUE(write_geopackage(folder / "a.gpkg", {written}, utm));
    return message_of(read_areas(folder / "a.gpkg", "photo", wkt));
  };
  const std::vector<Eigen::Vector3d> bow_tie = {{0, 0, 0}, {10, 10, 0}, {10, 0, 0}, {0, 10, 0}};
  const VectorLayer good = layer({{kSquare, {std::string("a.jpg")}}});
  EXPECT_EQ(read(good, utm), "none");
  const std::string crs = read(good, other);
  EXPECT_NE(crs.find("EPSG:32633"), std::string::npos) << crs;
  EXPECT_NE(crs.find("EPSG:32634"), std::string::npos) << crs;
  EXPECT_NE(read(good, "").find("the map's is none"), std::string::npos);
  EXPECT_NE(read(layer({{kSquare, {std::string("a.jpg")}}, {bow_tie, {std::string("a.jpg")}}}), utm)
                .find("feature 2 has a broken outline"),
            std::string::npos);
  EXPECT_NE(read(layer({{kSquare, {std::monostate()}}}), utm).find("feature 1 names no photograph"), std::string::npos);
  VectorLayer line = layer({{kSquare, {std::string("a.jpg")}}});
  line.kind = VectorKind::kLine;
  EXPECT_NE(read(line, utm).find("feature 1 is no polygon"), std::string::npos);
  VectorLayer unnamed = layer({{kSquare, {std::string("a.jpg")}}});
  unnamed.fields[0].name = "picture";
  EXPECT_NE(read(unnamed, utm).find("no layer has a field \"photo\""), std::string::npos);
  EXPECT_NE(message_of(read_areas(folder / "none.gpkg", "photo", utm)).find("does not exist"), std::string::npos);
  std::ofstream(folder / "text.gpkg") << "not a GeoPackage";
  EXPECT_NE(message_of(read_areas(folder / "text.gpkg", "photo", utm)).find("no vector file"), std::string::npos);
}

TEST(ReadAreas, AFileWithoutCrsIsOfALocalFrame) {
  const TestFolder folder;
  ASSERT_TRUE(write_geopackage(folder / "a.gpkg", {layer({{kSquare, {std::string("a.jpg")}}})}, ""));
  EXPECT_TRUE(read_areas(folder / "a.gpkg", "photo", ""));
  EXPECT_FALSE(read_areas(folder / "a.gpkg", "photo", wkt_of(32633)));
}

// Damaged files end in an answer: what is left, or an error. A few bytes in 100 kB mostly hit what nobody reads; a file
// that is cut off or all but overwritten cannot be read.
TEST(ReadAreas, DamagedFilesDoNoHarm) {
  const TestFolder folder;
  const std::string utm = wkt_of(32633);
  ASSERT_TRUE(write_geopackage(folder / "a.gpkg", {layer({{kSquare, {std::string("a.jpg")}, {kHole}}})}, utm));
  std::ifstream file(folder / "a.gpkg", std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  const std::string whole = text.str();
  Random random(9);
  int read = 0, refused = 0;
  for (int trial = 0; trial < 60; ++trial) {
    std::string damaged =
        whole.substr(0, trial % 3 == 0 ? std::size_t(random.uniform(0, double(whole.size()))) : whole.size());
    const int bytes = trial % 3 == 1 ? 5 : 200;
    for (int k = 0; k < bytes && !damaged.empty(); ++k)
      damaged[std::size_t(random.uniform(0, double(damaged.size()) - 1))] = char(random.uniform(0, 255));
    std::ofstream(folder / "damaged.gpkg", std::ios::binary) << damaged;
    const auto areas = read_areas(folder / "damaged.gpkg", "photo", utm);
    ++(areas ? read : refused);
    if (areas)
      for (const NamedArea& area : *areas) EXPECT_FALSE(area.rings.empty());
    else
      EXPECT_NE(areas.error().message.find("damaged.gpkg"), std::string::npos) << areas.error().message;
  }
  EXPECT_GE(read, 10);  // of 20 that are little damaged
  EXPECT_GE(refused, 20);
}

}  // namespace
}  // namespace collinea
