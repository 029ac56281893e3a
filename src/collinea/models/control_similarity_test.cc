// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/control_similarity.h"

#include <gtest/gtest.h>

#include "collinea/models/test_models.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

std::vector<ControlPair> pairs_of(const Similarity3& ground_from_model, const std::vector<Vector3d>& in_model) {
  std::vector<ControlPair> pairs;
  for (const Vector3d& point : in_model) pairs.push_back({point, ground_from_model * point, {true, true, true}});
  return pairs;
}

void expect_similar(const std::optional<Similarity3>& found, const Similarity3& truth) {
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->scale / truth.scale, 1, 1e-7);
  EXPECT_LT(angle_between(found->rotation, truth.rotation), 1e-6);
}

const std::vector<Vector3d> kPoints = {{0, 0, 0.1}, {4, 0.3, -0.2}, {0.2, 3, 0.3}, {3, 2, -0.4}, {5, 4, 0.2}};

TEST(ControlSimilarity, FindsEveryAttitudeFromFullPoints) {
  Random random(3);
  for (int k = 0; k < 50; ++k) {
    const Similarity3 truth{200, rotation_by(2 * testing::normal3(random)), 100 * testing::normal3(random)};
    expect_similar(control_similarity(pairs_of(truth, kPoints)), truth);
  }
}

// Mussio 4.3.7: plan and height points apart.
TEST(ControlSimilarity, TwoPlanAndThreeHeightPointsAreEnough) {
  Random random(4);
  for (int k = 0; k < 20; ++k) {
    const Similarity3 truth{200,
                            rotation_by(Vector3d(0.1 * random.normal(), 0.1 * random.normal(), 2 * random.normal())),
                            100 * testing::normal3(random)};
    auto pairs = pairs_of(truth, kPoints);
    for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].has = {i < 2, i < 2, i >= 2};
    expect_similar(control_similarity(pairs), truth);
  }
}

// Two full points and a height: the block may lie on its back; the one with w upward is taken.
TEST(ControlSimilarity, TwoFullPointsAndAHeightLeaveTwoAttitudes) {
  const Similarity3 truth{50, rotation_by({0.05, -0.08, 1.3}), {10, 20, 30}};
  auto pairs = pairs_of(truth, {kPoints[0], kPoints[1], kPoints[2]});
  pairs[2].has = {false, false, true};
  expect_similar(control_similarity(pairs), truth);
}

TEST(ControlSimilarity, TooLittleControlHasNoAnswer) {
  const Similarity3 truth{50, rotation_by({0.05, -0.08, 1.3}), {10, 20, 30}};
  EXPECT_FALSE(control_similarity({}));
  auto pairs = pairs_of(truth, kPoints);
  for (auto& pair : pairs) pair.has = {true, true, false};  // no height: it may be mirrored and lie anywhere
  EXPECT_EQ(rank_of(pairs, truth).heights, 0);
  EXPECT_FALSE(control_similarity(pairs));
  for (auto& pair : pairs) pair.has = {false, false, true};
  EXPECT_FALSE(control_similarity(pairs));
  EXPECT_FALSE(control_similarity(pairs_of(truth, {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}})));  // a line
  EXPECT_FALSE(control_similarity(pairs_of(truth, {{0, 0, 0}, {1, 1, 1}})));
}

}  // namespace
}  // namespace collinea
