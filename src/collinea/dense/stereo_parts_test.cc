// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/stereo_parts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/dense/internal/test_pair.h"

namespace collinea {
namespace {

// A slope whose disparities reach from 12 to 50, in a picture of two parts, with a square before it.
test::TestPair slope() {
  return {.width = 1000, .height = 400, .at_left = 12.3, .slope = 0.038, .square = 60, .noise = 2};
}

constexpr DisparityRange kWhole{0, 120};

DisparityMap joined(const GreyImage& left, const GreyImage& right, const StereoParts& parts) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  DisparityMap map{FloatImage(left.width, left.height, 1, kNaN), FloatImage(left.width, left.height, 1, kNaN)};
  for (const StereoPart& part : parts.parts) {
    const auto found = match_part(left, right, part, {}, {});
    EXPECT_TRUE(found) << found.error().message;
    for (int y = 0; y < part.height; ++y) {
      std::copy_n(found->disparity.row(y), part.width, map.disparity.row(part.row + y) + part.column);
      std::copy_n(found->sigma.row(y), part.width, map.sigma.row(part.row + y) + part.column);
    }
  }
  return map;
}

TEST(StereoParts, EachHasTheDisparitiesOfItsReliefAlone) {
  const test::TestPair pair = slope();
  const auto parts = stereo_parts(pair.image_of(true), pair.image_of(false), kWhole, {}, {});
  ASSERT_TRUE(parts) << parts.error().message;
  ASSERT_EQ(parts->parts.size(), 2u);
  double pixels = 0;
  for (const StereoPart& part : parts->parts) {
    pixels += double(part.width) * part.height;
    const double low = pair.truth(part.column, 0), high = pair.truth(part.column + part.width - 1, 0);
    EXPECT_LE(part.range.low, low);
    EXPECT_GE(part.range.high, high);
    const bool has_square = part.column == 0;
    if (has_square) {
      EXPECT_GE(part.range.high, 60);  // 50 x 50 pixels of 768 x 400
    } else {                           // two reduced pixels and a sixth on either side, and rounding
      EXPECT_LT(part.range.high - part.range.low, 1.4 * (high - low) + 12);
    }
  }
  EXPECT_EQ(pixels, 1000.0 * 400);
}

TEST(StereoParts, AreMatchedAsWellAsTheWhole) {
  const test::TestPair pair = slope();
  const GreyImage left = pair.image_of(true), right = pair.image_of(false);
  const auto parts = stereo_parts(left, right, kWhole, {}, {});
  const auto whole = match_pair(left, right, kWhole, {}, {});
  ASSERT_TRUE(parts && whole);
  const DisparityMap map = joined(left, right, *parts);
  const auto by_parts = test::errors_of(pair, map), as_whole = test::errors_of(pair, *whole);
  EXPECT_GT(by_parts.measured, 0.995 * as_whole.measured);
  // Fewer disparities to choose from leave no more wrong ones.
  EXPECT_LE(by_parts.bad, as_whole.bad + 20);
  EXPECT_NEAR(by_parts.rms, as_whole.rms, 0.02 * as_whole.rms);
}

TEST(StereoParts, WhatTheRightImageDoesNotShowIsNoPart) {
  const test::TestPair pair = slope();
  const GreyImage left = pair.image_of(true), whole = pair.image_of(false);
  GreyImage right(500, whole.height);  // ends where the first part's does about
  for (int y = 0; y < right.height; ++y) std::copy_n(whole.row(y), right.width, right.row(y));
  const auto parts = stereo_parts(left, right, kWhole, {}, {});
  ASSERT_TRUE(parts) << parts.error().message;
  for (const StereoPart& part : parts->parts) EXPECT_EQ(part.column, 0);
  EXPECT_EQ(parts->parts.size(), 1u);
  EXPECT_FALSE(stereo_parts(left, GreyImage(500, 399), kWhole, {}, {}));
}

}  // namespace
}  // namespace collinea
