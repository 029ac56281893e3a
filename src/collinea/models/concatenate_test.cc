// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/concatenate.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "collinea/models/test_models.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using testing::test_models;
using testing::TestModels;
using testing::TestModelsOptions;

JoinedBlock chained(const TestModels& made, bool sigmas_known = true) {
  auto block = concatenate_models(made.models, made.control, sigmas_known);
  EXPECT_TRUE(block) << block.error().message;
  return block ? *std::move(block) : JoinedBlock{};
}

TEST(Concatenate, ExactModelsGiveTheTruth) {
  const TestModels made = test_models({});
  const JoinedBlock block = chained(made);
  ASSERT_EQ(block.points.size(), made.truth.size());
  for (const JoinedPoint& point : block.points)
    EXPECT_LT((point.position - made.truth.at(point.name)).norm(), 1e-6) << point.name;
  EXPECT_LT(block.squares, 1e-9);
}

// Positions are those of the chain, and every derivative is what happens when one coordinate is changed: the covariance
// of points by numeric differences of the whole concatenation.
void expect_numeric(const TestModels& made) {
  const JoinedBlock block = chained(made);
  std::map<std::string, Eigen::Matrix3d> numeric;
  const auto add = [&](TestModels changed, TestModels back, double by, double variance) {
    const JoinedBlock more = chained(changed), less = chained(back);
    for (std::size_t i = 0; i < block.points.size(); ++i) {
      const Vector3d slope = (more.points[i].position - less.points[i].position) / (2 * by);
      auto [at, is_new] = numeric.try_emplace(block.points[i].name, Eigen::Matrix3d::Zero());
      at->second += variance * slope * slope.transpose();
    }
  };
  for (std::size_t m = 0; m < made.models.size(); ++m)
    for (std::size_t i = 0; i < made.models[m].points.size(); ++i)
      for (int axis = 0; axis < 3; ++axis) {
        TestModels more = made, less = made;
        const double by = 1e-6;  // of models whose unit is the base
        more.models[m].points[i].position[axis] += by;
        less.models[m].points[i].position[axis] -= by;
        add(more, less, by, made.models[m].points[i].covariance(axis, axis));
      }
  for (std::size_t k = 0; k < made.control.size(); ++k)
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = made.control[k].sigma[axis];
      if (!made.control[k].has(axis) || made.control[k].is_check) continue;
      TestModels more = made, less = made;
      more.control[k].position[axis] += 1e-3;
      less.control[k].position[axis] -= 1e-3;
      add(more, less, 1e-3, sigma * sigma);
    }
  for (const JoinedPoint& point : block.points)
    EXPECT_LT((point.covariance - numeric.at(point.name)).norm(), 1e-3 * point.covariance.norm() + 1e-18) << point.name;
}

TEST(Concatenate, CovarianceIsThatOfNumericDerivatives) {
  expect_numeric(test_models({.strips = 2, .models = 3, .sigma = 0.001, .control_sigma_m = 0.002}));
}

TEST(Concatenate, AlsoWithoutControl) {
  TestModels made = test_models({.strips = 1, .models = 4, .sigma = 0.001});
  made.control.clear();
  expect_numeric(made);
}

// Real errors: chi-squared over degrees of freedom of three points far apart, and of the models' parameters.
TEST(Concatenate, CovariancesTellTheTruth) {
  double sum = 0, parameters = 0, count = 0, sigma0 = 0;
  const int seeds = 300;
  for (int seed = 1; seed <= seeds; ++seed) {
    const TestModels made = test_models({.sigma = 0.05,
                                         .control_sigma_m = 0.03,
                                         .correlated = seed % 2 == 0,
                                         .seed = static_cast<std::uint64_t>(seed)});
    const JoinedBlock block = chained(made);
    for (const JoinedPoint& point : block.points) {
      if (point.name != "P202" && point.name != "S2_0" && point.name != "O102") continue;
      const Vector3d error = point.position - made.truth.at(point.name);
      sum += error.dot(point.covariance.inverse() * error) / 3;
      ++count;
    }
    const JoinedModel& model = *block.models[2];
    const Similarity3 &found = model.ground_from_model, &truth = made.ground_from_model[2];
    parameters += std::pow(found.scale - truth.scale, 2) / model.covariance(6, 6) / seeds;
    sigma0 += block.sigma0 * block.sigma0 / seeds;
  }
  EXPECT_EQ(count, 3 * seeds);
  EXPECT_NEAR(sum / count, 1, 4 * std::sqrt(2.0 / (3 * seeds)));  // as if the three were one: four sigmas at most
  EXPECT_NEAR(parameters, 1, 4 * std::sqrt(2.0 / seeds));
  EXPECT_NEAR(sigma0, 1, 0.1);  // some fifty discrepancies a block: sigma of the mean below 0.02, correlated ones 0.03
}

// An unknown factor of all sigmas is found from the discrepancies.
TEST(Concatenate, UnknownSigmasComeFromTheDiscrepancies) {
  TestModels made = test_models({.sigma = 0.05});
  const JoinedBlock known = chained(made);
  for (StereoModel& model : made.models)
    for (NamedPoint& point : model.points) point.covariance *= 100;
  const JoinedBlock block = chained(made, false);
  EXPECT_NEAR(block.sigma0, known.sigma0 / 10, 1e-9);
  for (std::size_t i = 0; i < block.points.size(); ++i)
    EXPECT_LT((block.points[i].covariance - known.sigma0 * known.sigma0 * known.points[i].covariance).norm(),
              1e-9 * known.points[i].covariance.norm());
}

// Least squares at once are never worse.
TEST(Concatenate, IsNoBetterThanTheAdjustment) {
  const TestModels made = test_models({.sigma = 0.05, .control_sigma_m = 0.03});
  const JoinedBlock chain = chained(made);
  const auto block = join_models(made.models, made.control, {}, {});
  ASSERT_TRUE(block);
  ASSERT_EQ(block->points.size(), chain.points.size());
  for (std::size_t i = 0; i < chain.points.size(); ++i)
    EXPECT_GE(chain.points[i].covariance.trace(), block->points[i].covariance.trace() * (1 - 1e-3))
        << chain.points[i].name;  // geometry of the two differs by some 1e-4 of itself
}

}  // namespace
}  // namespace collinea
