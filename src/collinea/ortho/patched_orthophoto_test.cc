// SPDX-License-Identifier: Apache-2.0
// What people change of an orthophoto: patches taken from another photograph, and masks.
#include <gtest/gtest.h>

#include "collinea/ortho/test_orthophoto.h"

namespace collinea {
namespace {

const OrthoOptions kFine{.cell_m = 0.03, .feather_cells = 12, .balance = true, .seamlines = {}};  // four tiles

SeamPolygon rectangle(std::uint16_t source, double west, double south, double east, double north) {
  return {source, {{{west, south}, {east, south}, {east, north}, {west, north}}}};
}

EarlierOrthophoto earlier(const Product& product) {
  return {
      product.summary->kept, [&product](const CellArea& area) -> Result<OrthoTile> {
        OrthoTile tile{
            Raster<std::uint8_t>(area.width, area.height, 4), Raster<std::uint16_t>(area.width, area.height), {}, {}};
        for (int y = 0; y < area.height; ++y) {
          std::copy_n(product.rgba.row(area.row + y) + 4 * area.column, 4 * area.width, tile.rgba.row(y));
          std::copy_n(product.source.row(area.row + y) + area.column, area.width, tile.source.row(y));
        }
        return tile;
      }};
}

void expect_same(const Product& a, const Product& b) {
  ASSERT_TRUE(a.summary && b.summary);
  EXPECT_EQ(a.rgba.data, b.rgba.data);
  EXPECT_EQ(a.source.data, b.source.data);
  EXPECT_EQ(a.summary->seamlines, b.summary->seamlines);
  EXPECT_EQ(a.summary->not_followed, b.summary->not_followed);
  EXPECT_EQ(a.summary->painted_cells, b.summary->painted_cells);
  EXPECT_EQ(a.summary->images_used, b.summary->images_used);
  EXPECT_EQ(a.summary->seam_length_m, b.summary->seam_length_m);
  EXPECT_EQ(a.summary->seam_difference_grey, b.summary->seam_difference_grey);
  EXPECT_EQ(a.summary->seam_step_grey, b.summary->seam_step_grey);
}

TEST(PatchedOrthophoto, APatchIsTakenFromItsPhotographAndTheLaterOneLiesOnTop) {
  const World world;
  const Block block = block_of(nine_centres());
  const OrthoOptions options{.cell_m = {}, .feather_cells = 8, .balance = false, .seamlines = {}};
  const SeamGuides guides{.patches = {rectangle(1, 2, 2, 8, 8), rectangle(5, 5, 5, 9, 9)}};
  const Product product = make(world, block, options, false, 1, guides);
  ASSERT_TRUE(product.summary);
  const auto source = [&](double x, double y) {
    return product.source.at(int(product.grid.column_of(x)), int(product.grid.row_of(y)));
  };
  for (const double x : {2.3, 3.0, 4.7})
    for (const double y : {2.3, 5.0, 7.7}) EXPECT_EQ(source(x, y), 1) << x << ' ' << y;
  for (const double x : {5.3, 7.0, 8.7})
    for (const double y : {5.3, 7.0, 8.7}) EXPECT_EQ(source(x, y), 5) << x << ' ' << y;
}

// The same bits as an orthophoto that is made from nothing, whatever was added, moved, removed or put on top.
TEST(PatchedOrthophoto, OfAnEarlierOneOnlyWhatPatchesChangeIsMadeAnew) {
  const Block block = block_of({{4, 4, 50}, {28, 28, 50}, {16, 16, 50}});
  const SeamPolygon west = rectangle(3, 1, 26, 5, 30), middle = rectangle(1, 8, 24, 12, 28),
                    both = rectangle(2, 4, 25, 9, 27);
  const std::vector<std::vector<SeamPolygon>> lists = {{}, {west, both}, {both, west}, {middle}};
  std::vector<Product> anew;
  for (const auto& patches : lists) anew.push_back(make({}, block, kFine, true, 1, {.patches = patches}));
  ASSERT_GT(anew[0].grid.width, kOrthoTile);
  for (std::size_t i = 1; i < lists.size(); ++i) {
    SCOPED_TRACE(i);
    const EarlierOrthophoto before = earlier(anew[i - 1]);
    const Product patched = make({}, block, kFine, true, 2, {.patches = lists[i], .earlier = &before});
    expect_same(patched, anew[i]);
    EXPECT_EQ(patched.summary->kept_tiles, 3u);  // of four; all patches lie in the upper left one
    EXPECT_NE(patched.source.data, anew[i - 1].source.data);
  }
  // What was kept of another orthophoto is of no use, and does no harm.
  const Product other = make({}, block_of({{4, 4, 50}, {28, 28, 50}}), kFine, true);
  const EarlierOrthophoto wrong = earlier(other);
  const Product made = make({}, block, kFine, true, 1, {.earlier = &wrong});
  expect_same(made, anew[0]);
  EXPECT_EQ(made.summary->kept_tiles, 0u);
}

// Of the view in the west the left half is masked: nothing is taken from there, also where a patch asks for it.
TEST(PatchedOrthophoto, WhatAMaskHidesIsTakenFromElsewhere) {
  const World world;
  const Block block = block_of({{4, 16, 50}, {28, 16, 50}});
  const OrthoOptions options{.cell_m = {}, .feather_cells = 8, .balance = false, .seamlines = {}};
  ImageMasks masks;
  const Camera& camera = block.cameras.begin()->second;
  masks.add(ImageId{10}, {{0, 0}, {camera.width_px / 2.0, 0}, {camera.width_px / 2.0, 200}, {0, 200}});
  const SeamGuides guides{.masks = &masks, .patches = {rectangle(1, 0, 0, 32, 32)}};
  const Product product = make(world, block, options, false, 1, guides);
  ASSERT_TRUE(product.summary);
  const std::vector<View> views = views_of(block, nullptr);
  int masked = 0, taken = 0, wrong = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      if (product.source.at(x, y) == 0) continue;
      const double east = product.grid.east_of(x + 0.5), north = product.grid.north_of(y + 0.5);
      const double height = world.on_box(east, north) ? world.box_height_m : 0;
      const auto pixel = pixel_of(views[0], {east, north, height});
      // A tenth of a pixel: between the nodes of a lattice the orthophoto's way to the image is interpolated.
      const bool hidden = pixel && pixel->x() > 0 && pixel->x() < camera.width_px / 2.0 - 0.1;
      masked += hidden;
      taken += product.source.at(x, y) == 1;
      wrong += hidden && product.source.at(x, y) == 1;
    }
  EXPECT_LE(wrong, 10);  // a pinhole that no view sees follows the cells around it
  EXPECT_GT(masked, 500);
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace collinea
