// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/contours.h"

#include <gtest/gtest.h>
#include <ogr_api.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "collinea/base/test_folder.h"
#include "collinea/raster/gdal_access.h"

namespace collinea {
namespace {

// A cone of slope 1 about (50, 50) m: contours are circles of known radius.
struct Cone {
  MapGrid grid;
  FloatImage heights_m{200, 200};
  Cone() {
    grid.west_m = 5000, grid.north_m = 7000, grid.cell_m = 0.5;
    grid.width = grid.height = 200;
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x)
        heights_m.at(x, y) = float(100 - std::hypot((x + 0.5) * 0.5 - 50, (y + 0.5) * 0.5 - 50));
  }
};

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(Contours, OfAConeAreCirclesAtTheirHeights) {
  const TestFolder folder;
  const Cone cone;
  const auto lines = write_contours(cone.heights_m, cone.grid, 10, 0, folder / "c.gpkg", folder / "c.dxf");
  ASSERT_TRUE(lines) << lines.error().message;
  const GdalDataset file(
      GDALOpenEx((folder / "c.gpkg").c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY, nullptr, nullptr, nullptr));
  ASSERT_TRUE(file);
  const OGRLayerH layer = GDALDatasetGetLayer(file.get(), 0);
  std::uint64_t seen = 0;
  while (const OGRFeatureH feature = OGR_L_GetNextFeature(layer)) {
    const double height_m = OGR_F_GetFieldAsDouble(feature, OGR_F_GetFieldIndex(feature, "height_m"));
    EXPECT_DOUBLE_EQ(std::remainder(height_m, 10), 0);
    const OGRGeometryH line = OGR_F_GetGeometryRef(feature);
    for (int i = 0; i < OGR_G_GetPointCount(line); ++i) {
      const double x = OGR_G_GetX(line, i) - 5050, y = OGR_G_GetY(line, i) - 6950;
      if (std::max(std::abs(x), std::abs(y)) > 49.75) continue;  // beyond the outermost centres nothing is known
      const double radius_m = std::hypot(x, y);
      // Chords across a cell of 0.5 m bend away by 0.5^2 / 8 R.
      EXPECT_NEAR(radius_m, 100 - height_m, 0.5 * 0.5 / 8 / (100 - height_m) + 1e-4);
      EXPECT_EQ(OGR_G_GetZ(line, i), height_m);
    }
    ++seen;
    OGR_F_Destroy(feature);
  }
  EXPECT_EQ(seen, *lines);
  EXPECT_EQ(seen, 4u + 4 * 3);  // circles; those of 50, 60 and 70 m, the corners lying at 70.4, are four arcs each
  EXPECT_NE(bytes_of(folder / "c.dxf").find("POLYLINE"), std::string::npos);
}

TEST(Contours, TheSameHeightsMakeTheSameBytes) {
  const TestFolder folder;
  const Cone cone;
  ASSERT_TRUE(write_contours(cone.heights_m, cone.grid, 5, 0, folder / "a.gpkg", folder / "a.dxf"));
  ASSERT_TRUE(write_contours(cone.heights_m, cone.grid, 5, 0, folder / "b.gpkg", folder / "b.dxf"));
  EXPECT_EQ(bytes_of(folder / "a.gpkg"), bytes_of(folder / "b.gpkg"));
  EXPECT_EQ(bytes_of(folder / "a.dxf"), bytes_of(folder / "b.dxf"));
}

TEST(Contours, ShortLinesAreLeftOut) {
  const TestFolder folder;
  const Cone cone;
  const auto lines = write_contours(cone.heights_m, cone.grid, 10, 100, folder / "c.gpkg", folder / "c.dxf");
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_EQ(*lines, 3u);  // circles of 20, 30 and 40 m; that of 10 m is 63 m long, the arcs are no longer than 79 m
}

TEST(Contours, WhereNothingIsKnownThereIsNoLine) {
  const TestFolder folder;
  Cone cone;
  for (float& height : cone.heights_m.data) height = std::numeric_limits<float>::quiet_NaN();
  const auto lines = write_contours(cone.heights_m, cone.grid, 5, 0, folder / "a.gpkg", folder / "a.dxf");
  ASSERT_TRUE(lines) << lines.error().message;
  EXPECT_EQ(*lines, 0u);
}

TEST(Contours, AFolderThatIsNotThereIsAnErrorInWords) {
  const TestFolder folder;
  const Cone cone;
  const auto lines = write_contours(cone.heights_m, cone.grid, 5, 0, folder / "no/a.gpkg", folder / "no/a.dxf");
  ASSERT_FALSE(lines);
  EXPECT_NE(lines.error().message.find("a.gpkg"), std::string::npos) << lines.error().message;
}

}  // namespace
}  // namespace collinea
