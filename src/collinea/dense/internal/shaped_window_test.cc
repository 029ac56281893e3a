// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/shaped_window.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/dense/internal/plane_pair.h"

namespace collinea {
namespace {

using testing::PlanePair, testing::kWidth, testing::kHeight;

constexpr int kHalf = 10;
ShapedSearch search_of(double low, double high) { return {.low_px = low, .high_px = high, .rows = 1}; }

TEST(ShapedWindow, FindsWhatASquareOneDoesNot) {
  const PlanePair pair({0.4, -0.3}, 2, 3);
  int level = 0, shaped = 0, count = 0;
  for (int y = 30; y < 90; y += 12)
    for (int x = 90; x < 210; x += 12, ++count) {
      const Eigen::Vector2i pixel(x, y);
      const ShapedMatcher matcher(pair.left, pixel, kHalf, pair.right,
                                  search_of(pair.disparity(pixel) - 9.3, pair.disparity(pixel) + 8.1));
      const auto square = matcher.match({0, 0});
      level += square && square->ncc > 0.8;
      const auto found = matcher.match(pair.gradient);
      if (!found || found->ncc < 0.95) continue;
      ++shaped;
      // The top of a parabola through correlations a pixel apart.
      EXPECT_NEAR(found->disparity_px, pair.disparity(pixel), 0.15);
      EXPECT_NEAR(found->row_px, 0, 0.5);  // the right row
    }
  EXPECT_LT(level, count / 10);
  EXPECT_GT(shaped, 9 * count / 10);
}

// From a start that is half a pixel off and has no slope the fit comes to the disparity of the middle of the window,
// and its errors are as large as it says, of noise that is alike over neighbours, too: the mean square of error over
// sigma of 180 independent windows has the standard deviation sqrt(2 / 180) = 0.11, and that of the estimated variances
// (some 100 independent residuals each) adds little. Interpolation keeps noise of long waves, which moves the
// disparity, and takes some of the short ones from the residuals: a fifth of the variance. Three standard deviations.
void expect_true_errors(bool is_grain) {
  double squares = 0, bias = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const PlanePair pair({0.08, -0.05}, 4, seed, is_grain);
    for (int y = 35; y < 90; y += 25)
      for (int x = 120; x < 180; x += 25) {
        const Eigen::Vector2i pixel(x, y);
        const LevelPoint start{{x + 0.5, y + 0.5}, pair.disparity(pixel) + 0.5, 0, 1, 0};
        const auto found = fitted_plane(pair.left, kHalf, pair.right, start);
        ASSERT_TRUE(found);
        const double error = (found->disparity_px - pair.disparity(pixel)) / found->sigma_px;
        squares += error * error;
        bias += error;
        ++count;
        EXPECT_NEAR(found->gradient.x(), 0.08, 0.03);
        EXPECT_NEAR(found->gradient.y(), -0.05, 0.03);
      }
  }
  EXPECT_GT(squares / count, 1 - 0.33);
  EXPECT_LT(squares / count, 1.2 + 0.33);
  EXPECT_NEAR(bias / count, 0, 4 / std::sqrt(count));
}

TEST(ShapedWindow, TheFitErrsAsItSays) { expect_true_errors(false); }
TEST(ShapedWindow, TheFitErrsAsItSaysInGrain) { expect_true_errors(true); }

TEST(ShapedWindow, TheFitRefusesWhatDoesNotSettle) {
  const PlanePair pair({0, 0}, 2, 8);
  EXPECT_FALSE(fitted_plane(pair.left, kHalf, pair.right, {{150.5, 60.5}, 27, 0, 1, 0}));  // seven pixels off
  EXPECT_FALSE(fitted_plane(pair.left, kHalf, pair.right, {{4.5, 60.5}, 20, 0, 1, 0}));    // beyond the border
  EXPECT_FALSE(fitted_plane(GreyImage(kWidth, kHeight, 1, 90), kHalf, pair.right, {{150.5, 60.5}, 20, 0, 1, 0}));
}

}  // namespace
}  // namespace collinea
