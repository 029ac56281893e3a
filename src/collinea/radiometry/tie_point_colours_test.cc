// SPDX-License-Identifier: Apache-2.0
#include "collinea/radiometry/tie_point_colours.h"

#include <gtest/gtest.h>

#include <stop_token>

namespace collinea {
namespace {

// Two points of image 1, the second of which image 2 sees, too, and one of image 2 alone.
Block three_points() {
  Block block;
  for (const std::uint32_t point : {0, 1, 2}) block.points[PointId{point}] = {};
  const auto see = [&](std::uint32_t image, std::uint32_t point, double x, double y) {
    block.observations.push_back({ImageId{image}, PointId{point}, 0, {x, y}, 1});
  };
  see(1, 0, 4, 4);
  see(1, 1, 20, 12);
  see(2, 1, 4, 4);
  see(2, 2, 31.9, 15.9);
  return block;
}

// Channel c of cell (x, y) of an image: 100 * image + 16 * y + 4 * x + c.
Result<ColourImage> numbered(ImageId image, int shrink) {
  EXPECT_EQ(shrink, 8);
  ColourImage raster(4, 2, 3);
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) raster.at(x, y, c) = std::uint8_t(100 * int(image.value) + 16 * y + 4 * x + c);
  return raster;
}

using Colour = std::array<std::uint8_t, 3>;

TEST(TiePointColours, AreThoseOfTheFirstImage) {
  Block block = three_points();
  ASSERT_TRUE(colour_tie_points(numbered, block, collinea::Run{}));
  EXPECT_EQ(block.points.at(PointId{0}).colour, (Colour{100, 101, 102}));
  EXPECT_EQ(block.points.at(PointId{1}).colour, (Colour{124, 125, 126}));
  EXPECT_EQ(block.points.at(PointId{2}).colour, (Colour{228, 229, 230}));
}

TEST(TiePointColours, AnImageThatCannotBeReadColoursNothing) {
  Block block = three_points();
  const Colour before = block.points.at(PointId{0}).colour;
  const auto second_alone = [](ImageId image, int shrink) -> Result<ColourImage> {
    if (image == ImageId{1}) return fail(Errc::kNotFound, "gone");
    return numbered(image, shrink);
  };
  ASSERT_TRUE(colour_tie_points(second_alone, block, collinea::Run{}));
  EXPECT_EQ(block.points.at(PointId{0}).colour, before);
  EXPECT_EQ(block.points.at(PointId{1}).colour, before);
  EXPECT_EQ(block.points.at(PointId{2}).colour, (Colour{228, 229, 230}));
}

TEST(TiePointColours, MayBeCancelled) {
  Block block = three_points();
  std::stop_source stop;
  stop.request_stop();
  collinea::Run run;
  run.stop = stop.get_token();
  const auto coloured = colour_tie_points(numbered, block, run);
  ASSERT_FALSE(coloured);
  EXPECT_EQ(coloured.error().code, Errc::kCancelled);
}

}  // namespace
}  // namespace collinea
