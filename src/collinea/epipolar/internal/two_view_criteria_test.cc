// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/two_view_criteria.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numeric>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using namespace scene;

TEST(BeyondChance, MoreInliersAreRarerAndMoreMatchesMakeThemLessRare) {
  Random random(1);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 2000; ++i) points.push_back({random.uniform(0, 3000), random.uniform(0, 2000)});
  const std::vector<Eigen::Vector2d> some(points.begin(), points.begin() + 50);
  EXPECT_TRUE(beyond_chance(some, 18, 2.5));
  EXPECT_FALSE(beyond_chance(some, 8, 2.5));
  EXPECT_FALSE(beyond_chance(points, 18, 2.5));
  EXPECT_TRUE(beyond_chance(points, 100, 2.5));
  EXPECT_FALSE(beyond_chance(some, 5, 1e-6));
  EXPECT_FALSE(beyond_chance({}, 0, 2.5));
}

TEST(MostAlike, PrefersTheCommonTurnAndScale) {
  Random random(2);
  std::vector<RotationAndScale> changes;
  for (int i = 0; i < 300; ++i) {
    const bool right = i % 3 == 0;
    changes.push_back({right ? -3.1 + 0.1 * random.normal() : random.uniform(-9, 9),
                       right ? 0.8 + 0.1 * random.normal() : random.uniform(-12, 12)});
  }
  const std::vector<int> preferred = most_alike(changes);
  ASSERT_EQ(preferred.size(), 100u);
  EXPECT_GE(std::count_if(preferred.begin(), preferred.end(), [](int i) { return i % 3 == 0; }), 90);
  EXPECT_TRUE(most_alike({}).empty());
}

// Keypoints that move by the given distances.
std::vector<Match> moved(std::initializer_list<std::pair<int, float>> counts, std::vector<Keypoint>& first,
                         std::vector<Keypoint>& second) {
  std::vector<Match> matches;
  for (const auto& [count, distance_px] : counts)
    for (int i = 0; i < count; ++i) {
      const auto index = static_cast<std::uint32_t>(first.size());
      first.push_back({.x = 10.0f * index, .y = 50});
      second.push_back({.x = 10.0f * index, .y = 50 + distance_px});
      matches.emplace_back(index, index);
    }
  return matches;
}

TEST(WithoutMarks, LeavesOutWhatIsStillWhereAllElseMoves) {
  const auto left = [](std::initializer_list<std::pair<int, float>> counts) {
    std::vector<Keypoint> first, second;
    const auto matches = moved(counts, first, second);
    return without_marks(first, second, matches).size();
  };
  EXPECT_EQ(left({{5, 0.5f}, {100, 40.0f}}), 100u);
  EXPECT_EQ(left({{4, 0.5f}, {100, 40.0f}}), 104u);  // too few to tell
  EXPECT_EQ(left({{40, 1.4f}, {9, 3.0f}, {100, 40.0f}}), 109u);
  EXPECT_EQ(left({{40, 1.4f}, {10, 3.0f}, {100, 40.0f}}), 150u);  // the scene itself slows down
  EXPECT_EQ(left({{60, 0.1f}}), 0u);
  EXPECT_EQ(left({}), 0u);
}

TEST(NearlyAllStill, IsMoreThanNineTenths) {
  const auto still = [](std::initializer_list<std::pair<int, float>> counts) {
    std::vector<Keypoint> first, second;
    const auto matches = moved(counts, first, second);
    return nearly_all_still(first, second, matches);
  };
  EXPECT_FALSE(still({{90, 1.0f}, {10, 2.0f}}));
  EXPECT_TRUE(still({{91, 1.0f}, {9, 2.0f}}));
}

TEST(Breadth, IsTheScatterAcrossTheMainDirection) {
  Random random(3);
  std::vector<Eigen::Vector2d> points;
  std::vector<int> all(4000);
  std::iota(all.begin(), all.end(), 0);
  for (int i = 0; i < 4000; ++i) {
    const double along = random.uniform(-500, 500), across = 3 * random.normal();
    points.push_back({0.6 * along - 0.8 * across, 0.8 * along + 0.6 * across});
  }
  EXPECT_NEAR(breadth_px(points, all), 3, 4 * 3 / std::sqrt(2 * 4000.0));
}

// Half of the points off the plane: no doubt. All on it: the simpler relation wins.
TEST(Gric, PrefersThePlaneOnlyWhereThereIsOne) {
  const std::vector<double> small(200, 1.0);
  std::vector<double> half(200, 1.0);
  for (std::size_t i = 0; i < 100; ++i) half[i] = 400;
  std::vector<int> all(200);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_LT(gric(small, all, 1, 2, 8), gric(small, all, 1, 3, 5));
  EXPECT_GT(gric(half, all, 1, 2, 8), gric(small, all, 1, 3, 5));
}

TEST(DistanceFromRotation, IsZeroForRotationsOfAnyScale) {
  const Eigen::Matrix3d rotation = rotation_by({0.3, -0.1, 0.4}).toRotationMatrix();
  EXPECT_LT(distance_from_rotation(-4 * rotation), 1e-12);
  EXPECT_GT(distance_from_rotation(rotation + 0.1 * Eigen::Matrix3d::Ones()), 0.05);
}

}  // namespace
}  // namespace collinea
