// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/least_median.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>
#include <vector>

namespace collinea {
namespace {

TEST(LeastMedian, RankIsHalfOfAllAndHalfOfASample) {
  EXPECT_EQ(median_rank(10, 3), 7u);
  EXPECT_EQ(median_rank(11, 2), 6u);
  EXPECT_EQ(median_rank(3, 3), 3u);
}

// Of many normal errors the scale is their standard deviation, and one of a hundred is beyond the limit.
TEST(LeastMedian, ScaleAndLimitAreThoseOfNormalErrors) {
  constexpr int kErrors = 200'000;
  for (const int directions : {1, 2}) {
    Random random(7);
    std::vector<double> errors;
    for (int i = 0; i < kErrors; ++i)
      errors.push_back(3 *
                       (directions == 1 ? std::abs(random.normal()) : std::hypot(random.normal(), random.normal())));
    const auto rank = errors.begin() + static_cast<std::ptrdiff_t>(median_rank(errors.size(), 3)) - 1;
    std::nth_element(errors.begin(), rank, errors.end());
    const double sigma = robust_sigma(*rank, errors.size(), 3, directions);
    EXPECT_NEAR(sigma, 3, 0.03);
    const auto beyond =
        std::count_if(errors.begin(), errors.end(), [&](double e) { return e > wrong_beyond(directions) * 3; });
    EXPECT_NEAR(double(beyond) / kErrors, directions == 1 ? 0.0124 : 0.0098, 0.001);
  }
}

TEST(LeastMedian, TriplesAreAllOrDrawnOnes) {
  std::set<std::array<std::size_t, 3>> all;
  for_triples(7, 35, 1, [&](std::size_t i, std::size_t j, std::size_t k) { all.insert({i, j, k}); });
  EXPECT_EQ(all.size(), 35u);
  int drawn = 0;
  for_triples(8, 35, 1, [&](std::size_t i, std::size_t j, std::size_t k) {
    EXPECT_TRUE(i != j && j != k && i != k && i < 8 && j < 8 && k < 8);
    ++drawn;
  });
  EXPECT_LE(drawn, 35);
  EXPECT_GT(drawn, 15);
}

}  // namespace
}  // namespace collinea
