// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/models_of_block.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "collinea/math/fisher.h"
#include "collinea/models/model_block.h"
#include "collinea/models/test_strip.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using testing::strip;
using testing::Strip;

TEST(ModelsOfBlock, NeighboursInTheStripMakePairs) {
  const auto pairs = model_pairs(strip(1).block, {});
  ASSERT_EQ(pairs.size(), 3);
  for (std::uint32_t i = 0; i < 3; ++i) EXPECT_EQ(pairs[i], std::pair(ImageId{i + 1}, ImageId{i + 2}));
}

TEST(ModelsOfBlock, ExactMeasurementsGiveTheTruth) {
  const Strip made = strip(1, 4, 0);
  const auto formed = models_of_block(made.block, model_pairs(made.block, {}), {}, true, {});
  ASSERT_TRUE(formed) << formed.error().message;
  const auto block = join_models(formed->models, formed->control, {}, {});
  ASSERT_TRUE(block) << block.error().message;
  for (const JoinedPoint& point : block->points)
    EXPECT_LT((point.position - made.truth.at(point.name)).norm(), 1e-4) << point.name;
}

// One model by itself has no image in common with another: its covariance is that of the whole pair.
TEST(ModelsOfBlock, CovarianceOfAPairTellsTheTruth) {
  double sum = 0, within = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Strip made = strip(seed, 2);
    const auto formed = models_of_block(made.block, model_pairs(made.block, {}), {}, true, {});
    ASSERT_TRUE(formed) << formed.error().message;
    const auto block = join_models(formed->models, formed->control, {}, {});
    ASSERT_TRUE(block) << block.error().message;
    for (const JoinedPoint& point : block->points) {
      if (point.name != "3" && point.name != "17" && point.name != "i1") continue;
      const Vector3d error = point.position - made.truth.at(point.name);
      const double chi_squared = error.dot(point.covariance.inverse() * error);
      sum += chi_squared / 3;
      within += fisher_tail(chi_squared / 3, 3, INFINITY) > 0.05 ? 1 : 0;
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 1, 0.15);  // three points share a pair: about 100 independent values of 3
  EXPECT_NEAR(within / count, 0.95, 0.04);
}

TEST(ModelsOfBlock, WhatMakesNoModelIsNamed) {
  Strip made = strip(1);
  EXPECT_FALSE(models_of_block(made.block, {}, {}, true, {}));
  const auto far = models_of_block(made.block, {{ImageId{1}, ImageId{2}}, {ImageId{1}, ImageId{4}}}, {}, true, {});
  ASSERT_TRUE(far);
  EXPECT_EQ(far->models.size(), 1);
  EXPECT_FALSE(far->pairs[1].failure.empty());
  made.block.control[ControlId{0}].name = "i0";
  EXPECT_EQ(models_of_block(made.block, model_pairs(made.block, {}), {}, true, {}).error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
