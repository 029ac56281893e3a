// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/cubic_row.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "collinea/math/random.h"
#include "collinea/raster/cubic.h"

namespace collinea {
namespace {

// Rows that run across the image, along its borders, beyond it and through nothing.
TEST(CubicRow, HasTheBitsOfSinglePixels) {
  Random random(3);
  for (const int channels : {1, 3}) {
    Raster<std::uint8_t> image(83, 47, channels);
    for (auto& value : image.data) value = std::uint8_t(random.below(256));
    for (int row = 0; row < 200; ++row) {
      const int count = 1 + int(random.below(150));
      std::vector<float> x, y;
      const double x0 = random.uniform(-5, 40), y0 = random.uniform(-3, 50), step = random.uniform(0.2, 1.3);
      const double fall = random.uniform(-0.3, 0.3);
      for (int i = 0; i < count; ++i) {
        x.push_back(float(x0 + step * i));
        y.push_back(row % 7 == 0 && i % 41 == 5 ? NAN : float(y0 + fall * i));
      }
      std::vector<std::uint8_t> out(std::size_t(count * channels));
      cubic_row(image, x.data(), y.data(), count, out.data());
      for (int i = 0; i < count; ++i)
        for (int c = 0; c < channels; ++c) {
          const std::size_t k = std::size_t(i);
          const auto expected = channels == 1 ? cubic<1>(image, x[k], y[k]) : cubic<3>(image, x[k], y[k], c);
          ASSERT_EQ(out[std::size_t(i * channels + c)], expected) << row << ' ' << i << ' ' << c;
        }
    }
  }
}

}  // namespace
}  // namespace collinea
