// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/geodetic_scale.h"

#include <gtest/gtest.h>

#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

// Control points of an exact block with distances between them; the block is twice too small.
Block small_block(int distances) {
  Block block = testing::test_block({.rows = 2, .columns = 3, .points = 20, .control = 8});
  for (int i = 1; i <= distances; ++i) {
    const ControlId to{static_cast<std::uint32_t>(i)};
    const double length = (block.control.at({0}).position_in_world - block.control.at(to).position_in_world).norm();
    block.geodetic.push_back({.from = {0}, .to = to, .value = length, .sigma = 1e-4 * length});
  }
  for (auto [id, pose] : oriented_images(block)) {
    pose.translation /= 2;
    set_pose(block, id, pose);
  }
  return block;
}

TEST(GeodeticScale, IsThatOfTheDistances) {
  const auto found = geodetic_scale(small_block(4));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->scale, 2, 1e-8);
  EXPECT_EQ(found->distances, 4);
  EXPECT_GT(found->sigma, 0.5e-4);  // the mean of four, and the image measurements
  EXPECT_TRUE(found->findings.empty());
}

TEST(GeodeticScale, AWrongDistanceIsNamedAndLeftOut) {
  Block block = small_block(4);
  block.geodetic[2].value *= 1.05;
  const auto found = geodetic_scale(block);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->scale, 2, 1e-8);
  ASSERT_EQ(found->excluded, std::vector<std::size_t>{2});
  ASSERT_EQ(found->findings.size(), 1u);
  EXPECT_EQ(found->findings[0].code, FindingCode::kDistanceWrong);
  EXPECT_EQ(found->findings[0].subjects, std::vector{Subject::geodetic(2)});
  EXPECT_NEAR(found->findings[0].figure(FigureName::kRelative).value_or(0), 0.05, 1e-6);
}

TEST(GeodeticScale, OfTwoThatContradictEachOtherNoneIsStatedWrong) {
  Block block = small_block(2);
  block.geodetic[1].value *= 1.1;
  const auto found = geodetic_scale(block);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->excluded.empty());
  EXPECT_EQ(found->distances, 2);
  ASSERT_EQ(found->findings.size(), 1u);
  EXPECT_EQ(found->findings[0].code, FindingCode::kDistancesContradict);
}

TEST(GeodeticScale, NeedsPointsThatTwoImagesShow) {
  Block block = small_block(1);
  std::erase_if(block.control_observations, [](const ControlObservation& seen) { return seen.point.value == 1; });
  EXPECT_FALSE(geodetic_scale(block));
  block = small_block(1);
  block.geodetic[0].role = ControlRole::kCheck;
  EXPECT_FALSE(geodetic_scale(block));
}

}  // namespace
}  // namespace collinea
