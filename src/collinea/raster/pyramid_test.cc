// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/pyramid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/math/random.h"

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

}  // namespace
}  // namespace collinea
