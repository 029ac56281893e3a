// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/dxf.h"

#include <gdal.h>
#include <gtest/gtest.h>
#include <ogr_api.h>

#include <map>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/raster/gdal_access.h"

namespace collinea {
namespace {

TEST(Dxf, IsReadBackByAnotherProgram) {
  const TestFolder folder;
  VectorLayer lines{.name = "edge lines", .kind = VectorKind::kLine};
  lines.rows.push_back({.positions = {{1, -2, 0}, {3.25, -4, 0}, {5, 6, 7.5}}, .values = {}});
  VectorLayer areas{.name = "discs", .kind = VectorKind::kPolygon};
  areas.rows.push_back({.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}}, .values = {}});
  VectorLayer points{.name = "centres", .kind = VectorKind::kPoint};
  points.rows.push_back({.positions = {{-1e6 + 0.123456, 2, 0}}, .values = {}});
  ASSERT_TRUE(write_dxf(folder / "a.dxf", {lines, areas, points}));

  set_up_gdal();
  const GdalDataset file(GDALOpenEx((folder / "a.dxf").c_str(), GDAL_OF_VECTOR, nullptr, nullptr, nullptr));
  ASSERT_TRUE(file);
  const OGRLayerH layer = GDALDatasetGetLayer(file.get(), 0);
  std::map<std::string, std::vector<Eigen::Vector3d>> read;
  while (const OGRFeatureH feature = OGR_L_GetNextFeature(layer)) {
    auto& positions = read[OGR_F_GetFieldAsString(feature, OGR_F_GetFieldIndex(feature, "Layer"))];
    const OGRGeometryH geometry = OGR_F_GetGeometryRef(feature);
    for (int i = 0; i < OGR_G_GetPointCount(geometry); ++i)
      positions.emplace_back(OGR_G_GetX(geometry, i), OGR_G_GetY(geometry, i), OGR_G_GetZ(geometry, i));
    OGR_F_Destroy(feature);
  }
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read["edge_lines"], lines.rows[0].positions);
  EXPECT_EQ(read["discs"], areas.rows[0].positions);  // closed: the first vertex again
  ASSERT_EQ(read["centres"].size(), 1u);
  EXPECT_NEAR(read["centres"][0].x(), -1e6 + 0.123456, 1e-6);
}

TEST(Dxf, WithoutLayersIsAnEmptyDrawing) {
  const TestFolder folder;
  ASSERT_TRUE(write_dxf(folder / "empty.dxf", {}));
  EXPECT_NE(read_file(folder / "empty.dxf")->find("EOF"), std::string::npos);
  EXPECT_FALSE(write_dxf("/dev/null/a.dxf", {}));
}

}  // namespace
}  // namespace collinea
