// SPDX-License-Identifier: Apache-2.0
#include "collinea/image/pyramid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/random.h"

namespace collinea {
namespace {

Raster<std::uint8_t> noise(int width, int height, int channels) {
  Raster<std::uint8_t> raster(width, height, channels);
  Random random(3);
  for (std::uint8_t& value : raster.data) value = std::uint8_t(random.below(256));
  return raster;
}

TEST(Pyramid, HalfIsTheRoundedMeanOfWhatEachPixelCovers) {
  for (const int channels : {1, 2, 3, 4})
    for (const auto& [width, height] :
         {std::pair(1, 1), std::pair(2, 2), std::pair(3, 5), std::pair(131, 67), std::pair(200, 4)}) {
      const Raster<std::uint8_t> raster = noise(width, height, channels);
      const Raster<std::uint8_t> small = half(raster);
      ASSERT_EQ(small.width, (width + 1) / 2);
      ASSERT_EQ(small.height, (height + 1) / 2);
      for (int y = 0; y < small.height; ++y)
        for (int x = 0; x < small.width; ++x)
          for (int c = 0; c < channels; ++c) {
            int sum = 0, count = 0;
            for (int v = 2 * y; v < std::min(2 * y + 2, height); ++v)
              for (int u = 2 * x; u < std::min(2 * x + 2, width); ++u) sum += raster.at(u, v, c), ++count;
            ASSERT_EQ(int(small.at(x, y, c)), int(std::floor(double(sum) / count + 0.5)))
                << width << ' ' << height << ' ' << x << ' ' << y;
          }
      ASSERT_EQ(small.data, shrunk(raster, 2).data);
    }
}

TEST(Pyramid, ResizedByAWholeFactorIsShrunk) {
  const Raster<std::uint8_t> raster = noise(60, 48, 3);
  EXPECT_EQ(resized(raster, 20, 16).data, shrunk(raster, 3).data);
  EXPECT_EQ(resized(raster, 60, 48).data, raster.data);
}

// Two of three input pixels: 1 + half of the next.
TEST(Pyramid, ResizedCountsPartsOfPixels) {
  Raster<std::uint8_t> raster(3, 1);
  raster.data = {30, 90, 240};
  EXPECT_EQ(resized(raster, 2, 1).data, (std::vector<std::uint8_t>{50, 190}));
}

TEST(Pyramid, ResizingKeepsAConstantPicture) {
  for (const int value : {0, 1, 254, 255}) {
    const Raster<std::uint8_t> raster(97, 53, 1, std::uint8_t(value));
    for (const std::uint8_t pixel : resized(raster, 31, 17).data) ASSERT_EQ(int(pixel), value);
  }
}

TEST(Pyramid, ABlurredPointIsAGaussian) {
  FloatImage point(61, 61);
  point.at(30, 30) = 1;
  const double sigma_px = 2.5;
  const FloatImage spread = blurred(point, sigma_px);
  for (int y = 25; y <= 35; ++y)
    for (int x = 25; x <= 35; ++x) {
      const double r2 = (x - 30) * (x - 30) + (y - 30) * (y - 30);
      // Cut off at four sigma the kernel misses 6e-5 of its sum.
      EXPECT_NEAR(spread.at(x, y), std::exp(-r2 / (2 * sigma_px * sigma_px)) / (2 * M_PI * sigma_px * sigma_px), 1e-5);
    }
  double sum = 0;
  for (const float value : spread.data) sum += value;
  EXPECT_NEAR(sum, 1, 1e-5);
}

TEST(Pyramid, BlurKeepsAConstantPictureUpToItsBorder) {
  const FloatImage flat(37, 5, 1, 3.0f);
  for (const float value : blurred(flat, 4).data) ASSERT_NEAR(value, 3, 1e-5);
}

TEST(Pyramid, AHardlyNoticeableBlurIsNone) {
  FloatImage point(5, 5);
  point.at(2, 2) = 1;
  EXPECT_EQ(blurred(point, 0.01).data, point.data);
}

}  // namespace
}  // namespace collinea
