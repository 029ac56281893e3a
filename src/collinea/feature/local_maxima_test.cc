// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/local_maxima.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace collinea {
namespace {

// A digit a pixel; what is no digit is not computed: 0.
FloatImage map_of(const std::vector<std::string>& rows) {
  FloatImage map(static_cast<int>(rows[0].size()), static_cast<int>(rows.size()));
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const char c = rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
      map.at(x, y) = c >= '0' && c <= '9' ? static_cast<float>(c - '0') : 0;
    }
  return map;
}

// Karfis W2: the corner map of his figure 5 has two maxima of 2, in (row, column) = (5, 8) and (4, 13), from 1.
TEST(LocalMaxima, TheCornerMapOfKarfisW2HasTwo) {
  const FloatImage map = map_of({"XXXXXXXXXXXXXXXX", "XXXXXXXXXXXXXXXX", "XX000000000111XX", "XX000001100121XX",
                                 "XX000002100111XX", "XX000000000000XX", "XXXXXXXXXXXXXXXX", "XXXXXXXXXXXXXXXX"});
  const std::vector<MapPixel> expected = {{12, 3, 2}, {7, 4, 2}};
  EXPECT_EQ(local_maxima(map, 1, 0), expected);
}

// Karfis W3: a noisy pixel of an edge is as strong as the corner, and a plateau of twos is one maximum, in its middle.
TEST(LocalMaxima, APlateauIsOneInKarfisW3) {
  const FloatImage map = map_of({"XXXXXXXXXXXXXXXX", "XXXXXXXXXXXXXXXX", "XX000000000111XX", "XX121001100121XX",
                                 "XX222002100111XX", "XX111000000000XX", "XXXXXXXXXXXXXXXX", "XXXXXXXXXXXXXXXX"});
  const std::vector<MapPixel> expected = {{12, 3, 2}, {3, 4, 2}, {7, 4, 2}};
  EXPECT_EQ(local_maxima(map, 1, 0), expected);
}

TEST(LocalMaxima, AShoulderIsNone) {
  const FloatImage map = map_of({"00000000", "05555590", "00000000"});
  ASSERT_EQ(local_maxima(map, 1, 0).size(), 1u);
  EXPECT_EQ(local_maxima(map, 1, 0)[0], (MapPixel{6, 1, 9}));
}

TEST(LocalMaxima, OfEqualsWithinTheRadiusOneStays) {
  const FloatImage map = map_of({"0000000", "0303000", "0000000", "0000030"});
  EXPECT_EQ(local_maxima(map, 1, 0).size(), 3u);
  const std::vector<MapPixel> expected = {{1, 1, 3}, {5, 3, 3}};
  EXPECT_EQ(local_maxima(map, 3, 0), expected);
}

TEST(LocalMaxima, TheThresholdItselfIsNotReached) {
  EXPECT_TRUE(local_maxima(map_of({"000", "020", "000"}), 1, 2).empty());
  EXPECT_TRUE(local_maxima(FloatImage(0, 0), 3, 0).empty());
  EXPECT_TRUE(local_maxima(FloatImage(3, 3, 1, std::numeric_limits<float>::quiet_NaN()), 1, 0).empty());
}

}  // namespace
}  // namespace collinea
