// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/anblock.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/models/model_block.h"
#include "collinea/models/test_models.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using testing::test_models;
using testing::TestModels;

TestModels level_models(double sigma, std::uint64_t seed = 1, double control_sigma_m = 0) {
  return test_models({.sigma = sigma, .control_sigma_m = control_sigma_m, .level = true, .seed = seed});
}

Result<Anblock> joined(const TestModels& made, const AnblockOptions& options = {}) {
  return anblock(made.models, std::vector<bool>(made.models.size(), true), made.control, options, {});
}

// Mussio 4.2.4: from zero, three or four cycles.
TEST(Anblock, ExactModelsGiveTheTruthAfterAFewCycles) {
  const TestModels made = level_models(0);
  const auto block = joined(made);
  ASSERT_TRUE(block) << block.error().message;
  for (const auto& [name, point] : block->points)
    EXPECT_LT((point.position - made.truth.at(name)).norm(), 1e-3) << name;
  EXPECT_LE(block->cycles.size(), 12);  // centres tie tilts to the plan: a third remains of each cycle's move
  const auto without = joined(test_models({.level = true, .centres = false}), {.settled = 1e-6});
  ASSERT_TRUE(without);
  ASSERT_GE(without->cycles.size(), 4);
  EXPECT_LT(without->cycles[3].largest_move, 0.01);  // m, of 1200 m and tilts of 0.03
  for (std::size_t m = 0; m < made.models.size(); ++m)
    EXPECT_LT(angle_between(block->models[m]->ground_from_model.rotation, made.ground_from_model[m].rotation), 1e-6);
}

TEST(Anblock, TiltsAreSmallAnglesNoLongerAtTheEnd) {
  TestModels made = test_models({.level = true, .centres = false});
  for (StereoModel& model : made.models) model = levelled(model, rotation_by({0.2, -0.15, 0}));
  const auto block = joined(made, {.most_cycles = 50, .settled = 1e-6});
  ASSERT_TRUE(block) << block.error().message;
  for (const auto& [name, point] : block->points)
    EXPECT_LT((point.position - made.truth.at(name)).norm(), 1e-3) << name;
}

// Points in plan and height against the spatial adjustment of the same models.
TEST(Anblock, AgreesWithTheSpatialAdjustmentWithinItsSigmas) {
  const TestModels made = level_models(0.05, 3, 0.02);
  const auto block = joined(made);
  ASSERT_TRUE(block) << block.error().message;
  const auto spatial = join_models(made.models, made.control, {}, {});
  ASSERT_TRUE(spatial);
  for (const JoinedPoint& point : spatial->points) {
    const Vector3d sigma = point.covariance.diagonal().cwiseSqrt();
    const AnblockPoint& other = block->points.at(point.name);
    EXPECT_LT((other.position - point.position).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 2) << point.name;
    EXPECT_LT((other.sigma.cwiseQuotient(sigma).array().log().abs().maxCoeff()), std::log(2.0)) << point.name;
  }
}

// Without projection centres plan and height of flat models have nothing to do with each other.
TEST(Anblock, StandardDeviationsTellTheTruthOfFlatModels) {
  const int seeds = 300;
  double sum = 0, within = 0, squares = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const TestModels made = test_models({.relief_m = 5,
                                         .sigma = 0.05,
                                         .control_sigma_m = 0.03,
                                         .level = true,
                                         .centres = false,
                                         .seed = static_cast<std::uint64_t>(seed)});
    const auto block = joined(made);
    ASSERT_TRUE(block) << block.error().message;
    for (const char* name : {"P1", "P202", "S2_0"}) {
      const AnblockPoint& point = block->points.at(name);
      const Vector3d w = (point.position - made.truth.at(name)).cwiseQuotient(point.sigma);
      sum += w.squaredNorm() / 9 / seeds;
      within += double((w.array().abs() < 1.959964).count()) / 9 / seeds;
    }
    squares += std::pow(block->cycles.back().plan_sigma0, 2) / seeds / 2 +
               std::pow(block->cycles.back().height_sigma0, 2) / seeds / 2;
  }
  EXPECT_NEAR(sum, 1, 0.1);
  EXPECT_NEAR(within, 0.95, 0.02);
  EXPECT_NEAR(squares, 1, 0.06);
}

// Mussio 4.2.5: the elimination is exact for points in two models with the weights of the text, and in more with ours.
// All models of one point at once, with its coordinate as an unknown, are the comparison.
TEST(Anblock, InghillerisEliminationIsExactWithMoreThanTwoModels) {
  const double weights[3] = {1, 2, 5}, values[3] = {3, -1, 4};
  const double sum = weights[0] + weights[1] + weights[2];
  double mean = 0, by_mean = 0, by_pairs = 0;
  for (int i = 0; i < 3; ++i) mean += weights[i] * values[i] / sum;
  for (int i = 0; i < 3; ++i) {
    by_mean += weights[i] * std::pow(values[i] - mean, 2);
    for (int k = i + 1; k < 3; ++k) by_pairs += weights[i] * weights[k] / sum * std::pow(values[i] - values[k], 2);
  }
  EXPECT_NEAR(by_mean, by_pairs, 1e-12);
}

TEST(Anblock, DegenerateBlocksAreNamed) {
  TestModels made = level_models(0.05);
  const auto control = made.control;
  made.control.clear();
  EXPECT_NE(joined(made).error().message.find("0 points in plan"), std::string::npos);
  made.control = {control[0], control[1]};
  EXPECT_NE(joined(made).error().message.find("2 heights"), std::string::npos);
  EXPECT_FALSE(anblock({}, {}, {}, {}, {}));
}

}  // namespace
}  // namespace collinea
