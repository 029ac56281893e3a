// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/find_edges.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// Two dark discs on bright ground.
GreyImage discs() {
  GreyImage image(120, 80);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 120; ++x) {
      double inside = 0;
      for (const Vector2d& c : {Vector2d(30.25, 40.5), Vector2d(85.75, 38.25)})
        inside += 0.5 * std::erfc(((Vector2d(x + 0.5, y + 0.5) - c).norm() - 15) / 1.1);
      image.at(x, y) = std::uint8_t(std::lround(200 - 150 * inside));
    }
  return image;
}

class FindEdges : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(write_png(folder_ / "discs.png", discs())); }
  [[nodiscard]] Result<EdgesReport> find(const FindEdgesOptions& options) const {
    return find_edges(folder_ / "discs.png", folder_ / "out", options, {});
  }
  TestFolder folder_;
};

TEST_F(FindEdges, TablesVectorsAndImagesOfWhatIsFound) {
  for (const auto& entry : kEdgeFindWords) {
    if (entry.value == EdgeFind::kShapes) continue;
    FindEdgesOptions options;
    options.find = entry.value;
    const auto report = find(options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->chains, 2u);
    if (entry.value != EdgeFind::kLines && entry.value != EdgeFind::kCorners) {
      EXPECT_EQ(report->found.rows.size(), 2u) << entry.word;
    }
    for (const auto& file : report->files) EXPECT_TRUE(is_there(file)) << file;
    EXPECT_NE(edges_text(*report).find(entry.word), std::string::npos);
    const auto table = read_text_table(folder_ / "out/found.txt");
    ASSERT_TRUE(table) << table.error().message;
    EXPECT_EQ(table->rows.size(), report->found.rows.size());
  }
}

TEST_F(FindEdges, CentresOfTargetsAtGivenPoints) {
  ASSERT_TRUE(write_file(folder_ / "points.txt", "point x[px] y[px]\nA 31 40\nB 85 39\nC 60 60\n"));
  FindEdgesOptions options;
  options.find = EdgeFind::kTargets;
  options.points = folder_ / "points.txt";
  options.target_radius_px = 20;
  const auto report = find(options);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->not_measured, 1u);
  const auto x = report->found.numbers("x", "px"), y = report->found.numbers("y", "px");
  ASSERT_TRUE(x && y && x->size() == 2);
  EXPECT_EQ(report->found.words("point").value(), (std::vector<std::string>{"A", "B"}));
  EXPECT_LT((Vector2d((*x)[0], (*y)[0]) - Vector2d(30.25, 40.5)).norm(), 0.01);
  EXPECT_LT((Vector2d((*x)[1], (*y)[1]) - Vector2d(85.75, 38.25)).norm(), 0.01);
}

TEST_F(FindEdges, AShapeIsFoundTwice) {
  GreyImage shape(50, 50);
  const GreyImage all = discs();
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 50; ++x) shape.at(x, y) = all.at(x + 5, y + 15);
  ASSERT_TRUE(write_png(folder_ / "shape.png", shape));
  FindEdgesOptions options;
  options.find = EdgeFind::kShapes;
  options.shape = folder_ / "shape.png";
  const auto report = find(options);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->found.rows.size(), 2u);
  const double shift = std::abs((*report->found.numbers("x", "px"))[0] - (*report->found.numbers("x", "px"))[1]);
  EXPECT_NEAR(shift, 55.5, 0.05);
}

TEST_F(FindEdges, AShapeOfAnotherSizeIsFoundWithItsScale) {
  GreyImage shape(50, 50);  // a disc of 10 px, where those of the image have 15
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 50; ++x)
      shape.at(x, y) = std::uint8_t(
          std::lround(200 - 75 * std::erfc(((Vector2d(x + 0.5, y + 0.5) - Vector2d(25, 25)).norm() - 10) / 1.1)));
  ASSERT_TRUE(write_png(folder_ / "small.png", shape));
  FindEdgesOptions options;
  options.find = EdgeFind::kShapes;
  options.shape = folder_ / "small.png";
  const auto same_size = find(options);
  ASSERT_TRUE(same_size) << same_size.error().message;
  EXPECT_TRUE(same_size->found.rows.empty());
  options.shape_scale = "0.8,2";
  const auto report = find(options);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->found.rows.size(), 2u);
  // Smoothing by a pixel moves the edges of small discs inwards, by some 1 / (2 r): 0.05 of 10 and 0.03 of 15 px.
  const auto scales = report->found.numbers("scale", ""), sigmas = report->found.numbers("sigma_scale", "");
  ASSERT_TRUE(scales && sigmas);
  for (const double scale : *scales) EXPECT_NEAR(scale, 1.5, 0.02);
  for (const double sigma : *sigmas) EXPECT_TRUE(sigma > 0 && sigma < 0.01);
  for (const char* wrong : {"2,0.5", "0", "a", "1,2,3"}) {
    options.shape_scale = wrong;
    const auto refused = find(options);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().options.front().name, "shape_scale") << wrong;
  }
}

TEST_F(FindEdges, WhatIsWrongIsRefused) {
  EXPECT_FALSE(find_edges(folder_ / "nothing.png", folder_ / "out", {}, {}));
  FindEdgesOptions even;
  even.texture_window = 8;
  EXPECT_FALSE(find(even));
  FindEdgesOptions radii;
  radii.hough.smallest_radius_px = 50;
  radii.hough.largest_radius_px = 20;
  EXPECT_FALSE(find(radii));
  FindEdgesOptions no_shape;
  no_shape.find = EdgeFind::kShapes;
  EXPECT_FALSE(find(no_shape));
  ASSERT_TRUE(write_file(folder_ / "points.txt", "point x[px]\nA 31\n"));
  FindEdgesOptions points;
  points.find = EdgeFind::kTargets;
  points.points = folder_ / "points.txt";
  const auto refused = find(points);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("points.txt"), std::string::npos);
}

TEST_F(FindEdges, TextureIsWrittenWhereItIsAskedFor) {
  FindEdgesOptions options;
  options.texture = true;
  ASSERT_TRUE(find(options));
  EXPECT_TRUE(is_there(folder_ / "out/entropy_mask.png"));
}

TEST_F(FindEdges, CornersAreWhereLinesMeet) {
  GreyImage image(160, 120, 1, 60);
  for (int y = 30; y < 90; ++y)
    for (int x = 40; x < 120; ++x) image.at(x, y) = 180;
  ASSERT_TRUE(write_png(folder_ / "box.png", image));
  FindEdgesOptions options;
  options.find = EdgeFind::kCorners;
  options.edges.edge_operator = EdgeOperator::kRoberts;
  const auto report = find_edges(folder_ / "box.png", folder_ / "out", options, {});
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_EQ(report->found.rows.size(), 4u);
  const auto x = *report->found.numbers("x", "px"), y = *report->found.numbers("y", "px");
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(std::abs(x[i] - 80), 40, 0.05);
    EXPECT_NEAR(std::abs(y[i] - 60), 30, 0.05);
  }
  EXPECT_TRUE(is_there(folder_ / "out/lines.txt") && is_there(folder_ / "out/found.dxf"));
}

}  // namespace
}  // namespace collinea
