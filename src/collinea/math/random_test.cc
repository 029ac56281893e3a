// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace collinea {
namespace {

// The mean of n standard normal numbers has sigma 1/sqrt(n), their mean square sqrt(2/n); four sigmas each.
TEST(Random, NormalHasMeanZeroAndVarianceOne) {
  constexpr int n = 100'000;
  Random random(7);
  double sum = 0, sum_of_squares = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.normal();
    sum += x;
    sum_of_squares += x * x;
  }
  EXPECT_NEAR(sum / n, 0, 4 / std::sqrt(n));
  EXPECT_NEAR(sum_of_squares / n, 1, 4 * std::sqrt(2.0 / n));
}

TEST(Random, StreamsOfNeighbouringItemsDiffer) {
  EXPECT_NE(Random(1, 0).bits(), Random(1, 1).bits());
  EXPECT_NE(Random(1, 1).bits(), Random(2, 0).bits());
}

TEST(Random, BelowReachesEveryValue) {
  Random random(3);
  bool seen[5] = {};
  for (int i = 0; i < 200; ++i) seen[random.below(5)] = true;
  for (const bool value : seen) EXPECT_TRUE(value);
}

}  // namespace
}  // namespace collinea
