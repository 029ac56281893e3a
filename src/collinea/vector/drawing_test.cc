// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/drawing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace collinea {
namespace {

DrawnVertex vertex(double e, double n, double h, double sigma = 0) {
  DrawnVertex one{.position = {e, n, h}};
  if (sigma > 0) one.covariance_m2 = sigma * sigma * Eigen::Matrix3d::Identity();
  return one;
}

TEST(Drawing, ColoursComeBackFromTheirText) {
  for (const char* text : {"#000000", "#c0ffee", "#12ab9f"}) EXPECT_EQ(text_of(colour_in(text).value()), text);
  for (const char* text : {"", "c00000", "#c0000", "#c000000", "#g00000", "#-10000"}) EXPECT_FALSE(colour_in(text));
}

TEST(Drawing, LayersAreThoseNamedThenThoseOfCodesThenThoseOfFeatures) {
  Drawing drawing{.layers = {{"roof", VectorKind::kPolygon, {1, 2, 3}}}};
  drawing.features = {{"F1", "roof"}, {"F2", "new"}};
  const std::vector<DrawingCode> codes = {{"R", "roof", VectorKind::kLine, {9, 9, 9}, ""},
                                          {"T", "trees", VectorKind::kPoint, {4, 5, 6}, ""},
                                          {"H", "trees", VectorKind::kLine, {4, 5, 6}, ""}};
  const auto layers = layers_of(drawing, codes);
  ASSERT_EQ(layers.size(), 3u);
  EXPECT_EQ(layers[0].name, "roof");
  EXPECT_EQ(layers[0].colour, (LayerColour{1, 2, 3}));
  EXPECT_EQ(layers[0].kind, VectorKind::kPolygon);
  EXPECT_EQ(layers[1].name, "trees");
  EXPECT_FALSE(layers[1].kind);  // two kinds share it
  EXPECT_EQ(layers[2].name, "new");
}

// Layers called as tables that a GeoPackage keeps for itself are drawn all the same.
TEST(Drawing, NoTableHasAReservedName) {
  Drawing drawing;
  drawing.features = {{"F1", "sqlite", VectorKind::kPoint, {}, {vertex(5, 5, 5)}},
                      {"F2", "GPKG_x", VectorKind::kPoint, {}, {vertex(5, 5, 5)}}};
  const auto tables = vector_layers(drawing, {});
  ASSERT_EQ(tables.size(), 3u);
  EXPECT_EQ(tables[0].name, "layer_sqlite_point");
  EXPECT_EQ(tables[1].name, "layer_GPKG_x_point");
}

TEST(Drawing, TablesHoldFeaturesWithSigmasAndAttributesAndAllVertices) {
  Drawing drawing;
  drawing.features = {{"F1",
                       "roof",
                       VectorKind::kLine,
                       {{"Feature", "x"}, {"use", "shed"}},
                       {vertex(0, 0, 1, 0.1), vertex(1, 0, 1, 0.2)}},
                      {"F2", "roof", VectorKind::kLine, {}, {vertex(0, 0, 1), vertex(1, 0, 1, 0.2)}},
                      {"F3", "roof", VectorKind::kPoint, {}, {vertex(5, 5, 5)}},
                      {"F4", "ROOF", VectorKind::kPoint, {}, {vertex(6, 5, 5)}}};
  const auto tables = vector_layers(drawing, {});
  ASSERT_EQ(tables.size(), 4u);
  EXPECT_EQ(tables[0].name, "roof_point");
  EXPECT_EQ(tables[1].name, "roof_line");
  EXPECT_EQ(tables[2].name, "ROOF_point_2");  // a file knows no case
  const VectorLayer& lines = tables[1];
  ASSERT_EQ(lines.fields.size(), 8u);
  EXPECT_EQ(lines.fields[6].name, "Feature_2");
  EXPECT_EQ(lines.fields[7].name, "use");
  EXPECT_EQ(std::get<double>(lines.rows[0].values[3]), 0.2);  // the worst vertex
  EXPECT_EQ(std::get<std::string>(lines.rows[0].values[7]), "shed");
  EXPECT_TRUE(std::isnan(std::get<double>(lines.rows[1].values[3])));  // one is not known
  EXPECT_EQ(tables[3].name, "vertices");
  EXPECT_EQ(tables[3].rows.size(), 6u);
  EXPECT_EQ(std::get<std::int64_t>(tables[3].rows[1].values[2]), 2);
}

}  // namespace
}  // namespace collinea
