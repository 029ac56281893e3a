// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/colour_errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace collinea {
namespace {

using Paint = std::function<std::array<double, 3>(double x, double y)>;

ImageField image_of(double cell_m, int side, const Paint& paint) {
  ImageField field;
  field.grid = {0, side * cell_m, cell_m, side, side, ""};
  field.read = [=, grid = field.grid](int column, int row, int width, int height) -> Result<Raster<std::uint8_t>> {
    Raster<std::uint8_t> image(width, height, 4, 255);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c)
          image.at(x, y, c) = std::uint8_t(
              std::lround(paint(grid.east_of(column + x + 0.5), grid.north_of(row + y + 0.5))[std::size_t(c)]));
    return image;
  };
  return field;
}

std::array<double, 3> ground(double x, double y) {
  return {120 + 20 * std::sin(x), 110 + 20 * std::cos(y), 100 + 10 * std::sin(x + y)};
}

// The left quarter is of an image that is 10 % darker, the right one of one that is as much brighter, what lies
// between of two that are as bright as all are; all of it is 20 % darker than the truth. A square of 1 % of the area
// shows a wall.
TEST(ColourErrors, TellsBrightnessFromTheWrongSurface) {
  const auto made = [](double x, double y) {
    if (x > 10 && x < 14 && y > 10 && y < 14) return std::array<double, 3>{30, 30, 160};
    auto colour = ground(x, y);
    for (double& channel : colour) channel *= 0.8 * (x < 10 ? 0.9 : x < 30 ? 1 : 1.1);
    return colour;
  };
  const SourceReader sources = [](int column, int, int width, int height) -> Result<FloatImage> {
    FloatImage source(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) source.at(x, y) = 3 + float((column + x) / 100);
    return source;
  };
  const auto errors = colour_errors(image_of(0.1, 400, made), sources, image_of(0.11, 364, ground), collinea::Run{});
  ASSERT_TRUE(errors);
  EXPECT_EQ(errors->images, 4u);
  // Ratios are counted in steps of 0.002 and images rounded to whole levels.
  const double common = std::log(0.9 * 1.1) / 4, darker = std::log(0.9) - common, brighter = std::log(1.1) - common;
  const double rms = std::sqrt((darker * darker + brighter * brighter + 2 * common * common) / 4);
  EXPECT_NEAR(errors->gain_rms, rms, 0.003);
  EXPECT_NEAR(errors->gain_worst, -darker, 0.004);
  EXPECT_NEAR(errors->share_wrong, 0.01, 0.001);
  EXPECT_NEAR(double(errors->pixels), 396 * 396, 1'000);  // two cells of the truth are left out all around
}

TEST(ColourErrors, NothingInCommonIsAnError) {
  ImageField far = image_of(0.1, 50, ground);
  far.grid.west_m += 1000;
  EXPECT_FALSE(colour_errors(far, nullptr, image_of(0.1, 50, ground), collinea::Run{}));
}

}  // namespace
}  // namespace collinea
