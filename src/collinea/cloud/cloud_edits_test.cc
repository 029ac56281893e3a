// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/cloud_edits.h"

#include <gtest/gtest.h>

#include <utility>

namespace collinea {
namespace {

CloudRegion region(CloudAction action, std::uint8_t classification = 0) {
  return {.action = action, .classification = classification, .ring_m = {{0, 0}, {4, 0}, {4, 4}, {0, 4}}};
}

std::vector<CloudPoint> points(std::initializer_list<Eigen::Vector3d> positions) {
  std::vector<CloudPoint> points;
  for (const Eigen::Vector3d& position : positions) points.push_back({.position = position});
  return points;
}

TEST(CloudEdits, HeightsOfTheirEndsBelongToARegion) {
  CloudRegion prism = region(CloudAction::kCut);
  prism.low_m = 1;
  prism.high_m = 2;
  for (const auto& [height, inside] : {std::pair(0.999, false), {1.0, true}, {1.5, true}, {2.0, true}, {2.001, false}})
    EXPECT_EQ(prism.contains({2, 2, height}), inside) << height;
}

// Squares that share sides hold every point once.
TEST(CloudEdits, NeighboursSharePointsOnTheirSide) {
  CloudRegion left = region(CloudAction::kCut), right = left;
  for (Eigen::Vector2d& point : right.ring_m) point.x() += 4;
  for (double y = 0.25; y < 4; y += 0.25) EXPECT_NE(left.contains({4, y, 0}), right.contains({4, y, 0})) << y;
}

TEST(CloudEdits, TheLastClassGivenHolds) {
  CloudRegion above = region(CloudAction::kClassify, 6);
  above.low_m = 5;
  const CloudEdits edits({region(CloudAction::kClassify, 2), above, region(CloudAction::kCut)});
  EXPECT_EQ(edits.class_at({1, 1, 4}), 2);
  EXPECT_EQ(edits.class_at({1, 1, 6}), 6);
  EXPECT_EQ(edits.class_at({5, 1, 6}), std::nullopt);
}

TEST(CloudEdits, ASurfaceReadsClassesWhereSomethingIsNoise) {
  const CloudRegion cut = region(CloudAction::kCut), ground = region(CloudAction::kClassify, 2);
  EXPECT_EQ(text_of(regions_of_surface({cut, ground})), text_of(std::vector{cut}));
  const std::vector<CloudRegion> noise = {region(CloudAction::kClassify, 7), cut, ground};  // the last gives points back
  EXPECT_EQ(text_of(regions_of_surface(noise)), text_of(noise));
  EXPECT_EQ(text_of(regions_of_classes({cut, ground})), text_of(std::vector{ground}));
  CloudRegion higher = cut;
  higher.low_m = 3;
  EXPECT_NE(text_of(std::vector{higher}), text_of(std::vector{cut}));
  higher.high_m = std::exchange(higher.low_m, std::nullopt);
  EXPECT_NE(text_of(std::vector{higher}), text_of(std::vector{cut}));
}

TEST(CloudEdits, WhatIsBetweenCrossedSidesLiesInside) {
  CloudRegion star = region(CloudAction::kCut);
  star.ring_m = {{0, 0}, {4, 4}, {4, 0}, {0, 4}};
  EXPECT_TRUE(star.contains({0.5, 2, 0}));
  EXPECT_TRUE(star.contains({3.5, 2, 0}));
  EXPECT_FALSE(star.contains({2, 3.5, 0}));
  EXPECT_FALSE(star.contains({2, 0.5, 0}));
}

TEST(CloudEdits, ComeOneAfterTheOther) {
  CloudRegion low = region(CloudAction::kClassify, 2);
  low.high_m = 1;
  auto cloud = points({{1, 1, 0}, {1, 1, 5}, {9, 9, 0}});
  CloudEdits({region(CloudAction::kClassify, 6), low}).apply(cloud);
  ASSERT_EQ(cloud.size(), 3u);
  EXPECT_EQ(cloud[0].classification, 2);
  EXPECT_EQ(cloud[1].classification, 6);
  EXPECT_EQ(cloud[2].classification, 0);
  CloudEdits({region(CloudAction::kCrop), low}).apply(cloud);
  EXPECT_EQ(cloud.size(), 2u);
  CloudEdits({region(CloudAction::kCut)}).apply(cloud);
  EXPECT_TRUE(cloud.empty());
}

}  // namespace
}  // namespace collinea
