// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/outweighing_positions.h"

#include <gtest/gtest.h>

#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

// Twelve images whose positions err by their sigma of five metres.
Block vague_block() { return testing::test_block({.rows = 3, .columns = 4, .position_sigma_m = 5}); }

void claim(Block& block, std::uint32_t image, double sigma_m, double off_m) {
  PositionPrior& position = *block.images.at({image}).position;
  position.position_in_world = centre_of(pose_of(block, {image})) + Eigen::Vector3d(off_m, 0, 0);
  position.sigma_m.setConstant(sigma_m);
}

TEST(OutweighingPositions, OneThatClaimsCentimetresAmongVagueOnesIsNamed) {
  Block block = vague_block();
  claim(block, 14, 0.02, 475);
  const OutweighingPositions found = outweighing_positions(block, 1);
  ASSERT_EQ(found.images, std::vector<ImageId>{ImageId{14}});
  EXPECT_NEAR(found.findings[0].figure(FigureName::kOffset).value(), 475, 30);
  EXPECT_NEAR(found.findings[0].figure(FigureName::kSigma).value(), 0.02, 1e-9);
}

TEST(OutweighingPositions, GoodOnesStayHoweverFineTheyAre) {
  Block block = vague_block();
  EXPECT_TRUE(outweighing_positions(block, 1).images.empty());
  for (std::uint32_t image = 10; image < 16; ++image) claim(block, image, 0.02, 0);
  EXPECT_TRUE(outweighing_positions(block, 1).images.empty());
}

TEST(OutweighingPositions, AGrossOneOfTheSameSigmaIsLeftToTheLoss) {
  Block block = vague_block();
  claim(block, 14, 5, 475);
  EXPECT_TRUE(outweighing_positions(block, 1).images.empty());
}

TEST(OutweighingPositions, ThreeThatAgreeMayBeTheGoodOnes) {
  Block block = vague_block();
  for (const std::uint32_t image : {11U, 16U, 21U}) claim(block, image, 0.02, 475);
  EXPECT_TRUE(outweighing_positions(block, 1).images.empty());
}

TEST(OutweighingPositions, TooFewOthersSayNothing) {
  Block block = vague_block();
  for (std::uint32_t image = 14; image < 22; ++image) block.images.at({image}).position.reset();
  claim(block, 13, 0.02, 475);
  EXPECT_TRUE(outweighing_positions(block, 1).images.empty());
}

}  // namespace
}  // namespace collinea
