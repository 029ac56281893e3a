// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/row_correlation.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>

#include "collinea/match/area_matching.h"
#include "collinea/math/random.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

GreyImage random_image(std::uint64_t seed) {
  Random random(seed);
  GreyImage image(90, 60);
  for (auto& grey : image.data) grey = std::uint8_t(1 + random.below(255));
  return image;
}

// The largest correlation in a band by area matching, whose sums are made another way. Templates of one vector, of a
// part of one and of more.
TEST(RowCorrelation, IsTheLargestOfTheBand) {
  const GreyImage left = random_image(1), right = random_image(2);
  for (const std::int64_t target : testing::processor_targets()) {
    const testing::OnTarget chosen(target);
    int compared = 0;
    for (const int half : {2, 6, 7, 8, 10})
      for (int n = 0; n < 12; ++n) {
        const Eigen::Vector2i middle(30 + 2 * n, 15 + n);
        const SearchBand band{middle.x() - 9, middle.x() + 12, middle.y() - 1, middle.y() + 1};
        const auto best = best_correlation(left, middle, half, right, band);
        const CorrelationSurface surface = correlation_surface(left, middle, half, right, middle, 12, Similarity::kNcc);
        const auto at = [&](int x, int y) { return double(surface.values.at(x - surface.left, y - surface.top)); };
        // The largest of each row; among these the one whose parabola reaches highest.
        Eigen::Vector2i expected = {band.first_column, band.first_row};
        double highest = -2;
        for (int y = band.first_row; y <= band.last_row; ++y) {
          int best_x = band.first_column;
          for (int x = band.first_column; x <= band.last_column; ++x)
            if (at(x, y) > at(best_x, y)) best_x = x;
          double height = at(best_x, y);
          if (best_x > band.first_column && best_x < band.last_column) {
            const double slope = (at(best_x + 1, y) - at(best_x - 1, y)) / 2,
                         bend = at(best_x + 1, y) - 2 * at(best_x, y) + at(best_x - 1, y);
            height -= slope * slope / (2 * bend);
          }
          if (height > highest) {
            highest = height;
            expected = {best_x, y};
          }
        }
        if (expected.x() == band.first_column || expected.x() == band.last_column) {
          EXPECT_FALSE(best);
          continue;
        }
        ASSERT_TRUE(best) << hwy::TargetName(target) << half;
        EXPECT_EQ(best->pixel, expected) << hwy::TargetName(target) << half;
        EXPECT_NEAR(best->ncc, at(expected.x(), expected.y()), 1e-6);  // the surface is of single precision
        const auto top = [](double before, double here, double after) {
          return std::clamp((before - after) / (2 * (before - 2 * here + after)), -0.499, 0.499);
        };
        const auto [x, y] = std::pair(expected.x(), expected.y());
        EXPECT_NEAR(best->position_px.x(), x + 0.5 + top(at(x - 1, y), at(x, y), at(x + 1, y)), 1e-5);
        // Across the band the best may be lower than what lies beyond it: then there is no top.
        if (at(x, y - 1) - 2 * at(x, y) + at(x, y + 1) < 0) {
          EXPECT_NEAR(best->position_px.y(), y + 0.5 + top(at(x, y - 1), at(x, y), at(x, y + 1)), 1e-5);
        }
        ++compared;
      }
    EXPECT_GT(compared, 30);
  }
}

TEST(RowCorrelation, AtTheBorderThereIsNone) {
  const GreyImage image = random_image(1);
  EXPECT_FALSE(best_correlation(image, {3, 30}, 6, image, {0, 20, 29, 31}));
  EXPECT_FALSE(best_correlation(image, {30, 30}, 6, image, {-20, 2, 29, 31}));
  EXPECT_FALSE(best_correlation(image, {30, 30}, 6, image, {20, 40, 57, 59}));
  EXPECT_TRUE(best_correlation(image, {30, 30}, 6, image, {-90, 200, -30, 200}));
}

}  // namespace
}  // namespace collinea
