// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "collinea/math/random.h"

namespace collinea {
namespace {

GreyImage random_image(int width, int height, unsigned levels) {
  GreyImage image(width, height);
  Random random(7);
  for (auto& grey : image.data) grey = std::uint8_t(random.below(levels));
  return image;
}

// Karfis 7.5: E = -sum p log2 p of a 9 x 9 window; at most log2 81 = 6.34, not 8 (erratum 21 of that text).
// One other pixel: while a column of the window has entered and none has left yet, more pixels than a window has are
// alike (a table of n log n that ends before is read beyond its end: what stands there is chance, AddressSanitizer
// sees it).
TEST(Texture, EntropyOfAllButOnePixelAlike) {
  GreyImage image(60, 30, 1, 90);
  image.at(30, 15) = 40;
  for (const int side : {3, 9, 15}) {
    const std::vector<float> bits = entropy_of_row(image, side, 15);
    const double p = 1.0 / (side * side), one = -p * std::log2(p) - (1 - p) * std::log2(1 - p);
    for (int x = side; x < image.width - side; ++x)
      EXPECT_NEAR(double(bits[std::size_t(x)]), std::abs(x - 30) <= side / 2 ? one : 0, 1e-6) << side << " " << x;
  }
}

TEST(Texture, EntropyIsThatOfTheHistogram) {
  const GreyImage image = random_image(40, 30, 17);
  const FloatImage entropy = entropy_of(image, 9);
  for (const auto& [x, y] : {std::pair{20, 15}, {0, 0}, {39, 29}, {3, 28}}) {
    std::map<int, int> count;
    int pixels = 0;
    for (int v = std::max(0, y - 4); v <= std::min(29, y + 4); ++v)
      for (int u = std::max(0, x - 4); u <= std::min(39, x + 4); ++u, ++pixels) ++count[image.at(u, v)];
    double expected = 0;
    for (const auto& [grey, n] : count) expected -= double(n) / pixels * std::log2(double(n) / pixels);
    EXPECT_NEAR(entropy.at(x, y), expected, 1e-5);
  }
  GreyImage all(9, 9);
  for (int i = 0; i < 81; ++i) all.data[std::size_t(i)] = std::uint8_t(3 * i);
  EXPECT_NEAR(entropy_of(all, 9).at(4, 4), std::log2(81.0), 1e-5);
  EXPECT_EQ(entropy_of(GreyImage(20, 20, 1, 9), 9).at(10, 10), 0);
}

TEST(Texture, TheMaskKeepsWhatHasTexture) {
  GreyImage image(60, 30, 1, 100);
  const GreyImage rough = random_image(30, 30, 200);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 30; ++x) image.at(x + 30, y) = rough.at(x, y);
  const GreyImage mask = entropy_mask(entropy_of(image, 9), 4);
  EXPECT_EQ(mask.at(10, 15), 0);
  EXPECT_EQ(mask.at(50, 15), 255);
}

TEST(Texture, MeasuresOfAKnownPattern) {
  GreyImage stripes(30, 30);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 30; ++x) stripes.at(x, y) = x % 2 ? 16 : 0;
  const Texture texture = texture_of(stripes, 9);
  EXPECT_NEAR(texture.mean.at(14, 14), 16 * 4 / 9.0, 1e-4);
  EXPECT_NEAR(texture.deviation.at(14, 14), 16 * std::sqrt(4 / 9.0 * 5 / 9.0), 1e-3);
  EXPECT_NEAR(texture.contrast.at(14, 14), 2, 1e-5);  // 4 along rows, 0 along columns
  EXPECT_NEAR(texture.homogeneity.at(14, 14), (0.2 + 1) / 2, 1e-5);
  EXPECT_EQ(texture_of(GreyImage(5, 4, 1, 80), 9).deviation.at(2, 2), 0);
}

}  // namespace
}  // namespace collinea
