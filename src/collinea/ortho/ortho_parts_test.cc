// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "collinea/ortho/ortho_tile.h"

namespace collinea {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

// Cells of one view, of which `unseen` of the 5 x 5 in the middle are seen by nobody, the middle among them.
Labels with_unseen(int unseen) {
  Labels labels(9, 9, 1, 3);
  labels.at(4, 4) = kNoView;
  for (int i = 0, left = unseen - 1; left > 0; ++i) {
    auto& label = labels.at(2 + i % 5, 2 + i / 5);
    if (label != kNoView) label = kNoView, --left;
  }
  return labels;
}

TEST(Pinholes, CloseWhereNoMoreThanTenOfTwentyFiveCellsAreUnseen) {
  const FloatImage level(9, 9);
  for (const int unseen : {1, 10, 11, 25}) {
    Labels labels = with_unseen(unseen);
    close_pinholes(level, 4, labels);
    EXPECT_EQ(labels.at(4, 4), unseen <= 10 ? 3 : kNoView) << unseen;
  }
}

TEST(Pinholes, TakeTheViewOfMostCellsAround) {
  Labels labels(9, 9, 1, 2);
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 4; ++x) labels.at(x, y) = 1;  // 10 of 25
  labels.at(4, 4) = kNoView;
  close_pinholes(FloatImage(9, 9), 3, labels);
  EXPECT_EQ(labels.at(4, 4), 2);
}

TEST(Pinholes, HiddenPositionsKeepTheirBordersAndCellsWithoutHeightStayEmpty) {
  Labels labels(12, 12, 1, 0);
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 6; ++x) labels.at(x, y) = kNoView;
  labels.at(9, 6) = kNoView;
  FloatImage heights(12, 12);
  heights.at(9, 6) = kNone;
  const Labels before = labels;
  close_pinholes(heights, 1, labels);
  EXPECT_EQ(labels.data, before.data);
}

// Keys' kernel reproduces polynomials of degree 2.
TEST(Bicubic, ReproducesAParabola) {
  ColourImage image(12, 12, 3);
  const auto value = [](double x, double y, int c) {
    return 20 + 1.0 * c + (x - 0.5) * (x - 0.5) + (y - 0.5) * (x - 0.5);
  };
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = std::uint8_t(value(x + 0.5, y + 0.5, c));
  float colour[3];
  bicubic(image, 5.8, 4.3, colour);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(colour[c], value(5.8, 4.3, c), 1e-4);
}

// A tower of 133 m on a plateau hides points of it 266 m away, by lines of sight flatter than those from a pit that the
// area holds, too: what it casts over the area must not be determined by these alone.
TEST(OrthoScene, WhatIsFarAwayHidesPositionsAboveTheLowestOfTheArea) {
  HeightField surface;
  surface.grid = {0, 800, 1, 1760, 800, ""};
  surface.read = [](int column, int row, int width, int height) -> Result<FloatImage> {
    FloatImage heights(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const int u = column + x, v = row + y;
        heights.at(x, y) = u >= 1336 && u < 1342 && v < 40 ? 333.0f : u == 1700 && v == 700 ? 0.0f : 200.0f;
      }
    return heights;
  };
  const auto heights = overview(surface, collinea::Run{});
  ASSERT_TRUE(heights);
  View view;
  view.camera = ideal_camera(1000, 4000, 4000);
  view.centre_in_world = view.centre_in_map = {0.5, 783.5, 1000};
  view.rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
  view.cam_from_world = {Eigen::Quaterniond(view.rotation), -(view.rotation * view.centre_in_world)};
  OrthoScene scene;
  scene.grid = surface.grid;
  scene.surface = &surface, scene.surface_overview = &*heights;
  scene.views = {view};
  std::vector<std::size_t> views;
  const auto patch = make_patch(scene, {1600, 0, 128, 768}, views);
  ASSERT_TRUE(patch && *patch);
  const Occluders& occluders = (*patch)->occluders;
  const auto hidden = [&](double x) {
    return occluders.hide(x - occluders.column(), 16.5 - occluders.row(), 200, 0.5 - occluders.column(),
                          16.5 - occluders.row(), 1000);
  };
  EXPECT_TRUE(hidden(1602.5));
  EXPECT_TRUE(hidden(1604.5));
  EXPECT_FALSE(hidden(1630.5));
}

}  // namespace
}  // namespace collinea
