// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/sift_kernels.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "collinea/math/random.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

constexpr int kWidth = 150, kHeight = 120;

// A smooth random image with room after its last row.
std::vector<float> smooth_image(std::uint64_t seed) {
  Random random(seed);
  std::vector<float> pixels(kWidth * kHeight + kRowSlack);
  for (float& pixel : pixels) pixel = static_cast<float>(random.uniform(0, 255));
  for (int pass = 0; pass < 3; ++pass)
    for (const int step : {1, kWidth})
      for (int i = step; i + step < kWidth * kHeight; ++i)
        pixels[std::size_t(i)] =
            (pixels[std::size_t(i - step)] + 2 * pixels[std::size_t(i)] + pixels[std::size_t(i + step)]) / 4;
  return pixels;
}

// Every instruction set that this machine has and the library was built for.
class EveryTarget : public ::testing::TestWithParam<std::int64_t> {
 protected:
  testing::OnTarget target_{GetParam()};
  std::vector<float> pixels = smooth_image(1);
  BlurredImage image{pixels.data(), kWidth, kWidth, kHeight};
  [[nodiscard]] double at(int x, int y) const { return pixels[std::size_t(y * kWidth + x)]; }
};

INSTANTIATE_TEST_SUITE_P(Machine, EveryTarget, ::testing::ValuesIn(testing::processor_targets()),
                         [](const auto& instance) {
                           return std::string(hwy::TargetName(instance.param)) + "_" + std::to_string(instance.index);
                         });

TEST_P(EveryTarget, BothFiltersAreTheWeightedSum) {
  const std::vector<float> taps{0.3f, 0.2f, 0.1f, 0.05f};
  constexpr int kRadius = 3, kCount = 77;
  std::vector<float> along(kCount + kRowSlack), across(kCount + kRowSlack);
  filter_along_row(pixels.data() + 5 * kWidth + 10, kCount, taps.data(), kRadius, along.data());
  std::array<const float*, 2 * kRadius + 1> rows;
  for (int j = 0; j <= 2 * kRadius; ++j) rows[std::size_t(j)] = pixels.data() + (20 + j) * kWidth;
  filter_across_rows(rows.data(), kCount, taps.data(), kRadius, across.data());
  for (int x = 0; x < kCount; ++x) {
    double row_sum = 0, column_sum = 0;
    for (int j = -kRadius; j <= kRadius; ++j) {
      row_sum += double{taps[std::size_t(std::abs(j))]} * at(10 + x + j, 5);
      column_sum += double{taps[std::size_t(std::abs(j))]} * at(x, 23 + j);
    }
    ASSERT_NEAR(along[std::size_t(x)], row_sum, 1e-4);
    ASSERT_NEAR(across[std::size_t(x)], column_sum, 1e-4);
  }
}

TEST_P(EveryTarget, BytesAndDifferencesAreExact) {
  std::vector<std::uint8_t> bytes(77);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(3 * i + 100);
  std::vector<float> wide(bytes.size() + kRowSlack), difference(bytes.size() + kRowSlack);
  widen_row(bytes.data(), 77, wide.data());
  subtract_rows(wide.data(), pixels.data(), 77, difference.data());
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    ASSERT_EQ(wide[i], bytes[i]);
    ASSERT_EQ(difference[i], bytes[i] - pixels[i]);
  }
}

TEST_P(EveryTarget, ExtremaAreThoseOfTheDefinition) {
  const std::vector<float> planes[3] = {smooth_image(2), smooth_image(3), smooth_image(4)};
  int total = 0;
  for (int y = 1; y + 1 < kHeight; ++y) {
    // About a mean of zero, so that there are peaks and pits; below the middle plane's amplitude, so that there are
    // any.
    std::array<std::vector<float>, 9> copies;
    std::array<const float*, 9> rows;
    for (std::size_t k = 0; k < 9; ++k) {
      const float* from = planes[k / 3].data() + (y - 1 + int(k % 3)) * kWidth;
      copies[k].assign(from, from + kWidth + kRowSlack / 2);
      for (float& value : copies[k]) value = (value - 127) * (k / 3 == 1 ? 1.0f : 0.3f);
      copies[k].resize(kWidth + kRowSlack);
      rows[k] = copies[k].data();
    }
    std::vector<std::int32_t> found(kWidth), expected;
    found.resize(std::size_t(extrema_of_row(rows.data(), 3, kWidth - 2, 20, found.data())));
    for (int x = 3; x < kWidth - 2; ++x) {
      const float value = rows[4][x];
      bool peak = value > 20, pit = value < -20;
      for (const float* row : rows)
        for (int i = -1; i <= 1; ++i) {
          peak = peak && value >= row[x + i];
          pit = pit && value <= row[x + i];
        }
      if (peak || pit) expected.push_back(x);
    }
    ASSERT_EQ(found, expected) << y;
    total += int(expected.size());
  }
  EXPECT_GT(total, 50);
}

TEST_P(EveryTarget, DirectionHistogramIsThatOfTheDefinition) {
  for (const auto& [x, y, sigma] : {std::array{70.3f, 60.8f, 3.1f}, {4.2f, 5.1f, 4.0f}, {147.0f, 117.9f, 7.9f}}) {
    std::array<double, kDirectionBins> expected{};
    for (int row = 1; row < kHeight - 1; ++row)
      for (int column = 1; column < kWidth - 1; ++column) {
        const double r2 = std::pow(column - x, 2) + std::pow(row - y, 2);
        if (r2 > 9 * sigma * sigma) continue;
        const double gx = at(column + 1, row) - at(column - 1, row), gy = at(column, row + 1) - at(column, row - 1);
        const double weight = std::hypot(gx, gy) * std::exp(-r2 / (2 * sigma * sigma));
        const double bin = (std::atan2(gy, gx) / (2 * std::numbers::pi) + 1) * kDirectionBins;
        const double part = bin - std::floor(bin);
        expected[std::size_t(bin) % kDirectionBins] += weight * (1 - part);
        expected[std::size_t(bin + 1) % kDirectionBins] += weight * part;
      }
    std::array<float, kDirectionBins> histogram;
    direction_histogram(image, x, y, sigma, histogram.data());
    const double largest = *std::ranges::max_element(expected);
    for (std::size_t b = 0; b < expected.size(); ++b) ASSERT_NEAR(histogram[b], expected[b], 1e-3 * largest) << b;
  }
}

TEST_P(EveryTarget, GradientPatchIsThatOfTheDefinition) {
  struct Patch {
    float x, y, angle_rad, cell_px;
    int row_step;
  };
  for (const Patch& patch : {Patch{70.3f, 60.8f, 0.7f, 5.2f, 1},
                             {75.0f, 60.0f, 0.0f, 18.0f, 4},
                             {8.4f, 110.2f, 4.0f, 9.0f, 1},
                             {60.2f, 4.6f, 4.0f, 9.0f, 3},
                             {71.9f, 50.2f, 1.5707963f, 14.1f, 2}}) {
    std::array<double, 128> expected{};
    const double c = std::cos(patch.angle_rad), s = std::sin(patch.angle_rad);
    for (int row = 1; row < kHeight - 1; ++row)
      for (int column = 1; column < kWidth - 1; ++column) {
        if ((row - std::lround(patch.y)) % patch.row_step != 0) continue;
        const double dx = column - patch.x, dy = row - patch.y;
        const double u = (c * dx + s * dy) / patch.cell_px + 1.5, v = (c * dy - s * dx) / patch.cell_px + 1.5;
        const double gx = at(column + 1, row) - at(column - 1, row), gy = at(column, row + 1) - at(column, row - 1);
        const double weight =
            std::hypot(gx, gy) * std::exp(-(dx * dx + dy * dy) / (2 * 4 * patch.cell_px * patch.cell_px));
        const double turns = (std::atan2(gy, gx) - patch.angle_rad) / (2 * std::numbers::pi);
        const double direction = 8 * (turns - std::floor(turns));
        for (int j = 0; j < 4; ++j)
          for (int i = 0; i < 4; ++i)
            for (int k = 0; k < 8; ++k) {
              const double off = std::abs(std::remainder(direction - k, 8));
              expected[std::size_t((j * 4 + i) * 8 + k)] += weight * std::max(0.0, 1 - std::abs(u - i)) *
                                                            std::max(0.0, 1 - std::abs(v - j)) * std::max(0.0, 1 - off);
            }
      }
    std::array<float, 128> histogram;
    gradient_patch(image, patch.x, patch.y, patch.angle_rad, patch.cell_px, patch.row_step, histogram.data());
    const double largest = *std::ranges::max_element(expected);
    for (std::size_t b = 0; b < expected.size(); ++b) ASSERT_NEAR(histogram[b], expected[b], 2e-3 * largest) << b;
  }
}

}  // namespace
}  // namespace collinea
