// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_steps.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/jobs/internal/thinned_sample.h"
#include "collinea/math/median.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

PairFiles of_size(int width, int height) {
  PairFiles pair;
  pair.cameras.fill(ideal_camera(10'000, width, height));
  return pair;
}

TEST(PairSteps, ResolutionsFollowTheSizeOfTheImages) {
  PairChainOptions levels, dense;
  dense.surface = PairSurface::kDense;
  const PairFiles small = of_size(4000, 4000), scan = of_size(15'333, 15'333);
  EXPECT_EQ(shrinks_of(small, levels)->search, 1);
  EXPECT_EQ(shrinks_of(small, levels)->surface, 1);
  EXPECT_EQ(shrinks_of(scan, levels)->search, 4);
  EXPECT_EQ(shrinks_of(scan, levels)->surface, 1);
  EXPECT_EQ(shrinks_of(scan, dense)->surface, 2);
  dense.resolution = Resolution::kFull;
  EXPECT_EQ(shrinks_of(scan, dense)->surface, 1);
  levels.resolution = Resolution::kQuarter;
  EXPECT_EQ(shrinks_of(small, levels)->search, 4);
}

TEST(PairSteps, AResolutionThatNoMemoryHoldsIsRefused) {
  PairChainOptions options;
  options.resolution = Resolution::kFull;
  const auto shrinks = shrinks_of(of_size(2'000'000, 2'000'000), options);
  ASSERT_FALSE(shrinks);
  EXPECT_EQ(shrinks.error().options.front().name, "resolution");
}

// Quantiles of every fourth value of ten million: their order is known to 1 / (2 sqrt(2.5e6)) of all, four of which
// chance exceeds once in 16,000 seeds.
TEST(ThinnedSample, KeepsTheQuantilesOfMany) {
  ThinnedSample few, many;
  for (int i = 0; i < 1000; ++i) few.add(i);
  EXPECT_EQ(few.values().size(), 1000u);
  Random random(3);
  for (int i = 0; i < 10'000'000; ++i) many.add(random.uniform());
  EXPECT_GT(many.values().size(), 2'000'000u);
  EXPECT_LT(many.values().size(), 4'200'000u);
  EXPECT_NEAR(median(std::vector<double>(many.values())), 0.5, 4 * 0.5 / std::sqrt(2.5e6));
}

}  // namespace
}  // namespace collinea
