// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/datum.h"
#include "collinea/block/transform.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "collinea/adjust/test_block.h"
#include "collinea/epipolar/intersect.h"

namespace collinea {
namespace {

using testing::normal3;
using testing::test_block;

const Similarity3 kBlockFromWorld{0.05, rotation_by({2, -0.4, 1}), {3, 1, -7}};

double worst_centre(const Block& block, const Block& truth) {
  double worst = 0;
  for (const auto& [id, pose] : oriented_images(block))
    worst = std::max(worst, (centre_of(pose) - centre_of(pose_of(truth, id))).norm());
  return worst;
}

TEST(Datum, ExactPositionsBringAnArbitraryFrameHome) {
  Block truth = test_block();
  for (auto& [id, image] : truth.images)
    image.position = PositionPrior{centre_of(pose_of(truth, id)), Eigen::Vector3d::Constant(0.1)};
  Block block = truth;
  transform(block, kBlockFromWorld);
  const auto found = datum(block);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->by_control);
  EXPECT_EQ(found->images.size(), truth.images.size());
  transform(block, found->world_from_block);
  EXPECT_LT(worst_centre(block, truth), 1e-9);
}

TEST(Datum, ControlDecidesAgainstPositionsThatAreSystematicallyOff) {
  Block truth = test_block({.position_sigma_m = 1, .control = 9});
  for (auto& [id, image] : truth.images) image.position->position_in_world.z() += 73;
  Block block = truth;
  transform(block, kBlockFromWorld);
  const auto found = datum(block);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->by_control);
  transform(block, found->world_from_block);
  EXPECT_LT(worst_centre(block, truth), 1e-7);
}

TEST(Datum, AThirdOfWildPositionsDoesNoHarm) {
  Block truth = test_block({.rows = 4, .columns = 5, .position_sigma_m = 0.5});
  Random random(4);
  int wild = 0;
  for (auto& [id, image] : truth.images)
    if (++wild % 3 == 0) image.position->position_in_world += 200 * normal3(random);
  Block block = truth;
  transform(block, kBlockFromWorld);
  const auto found = datum(block);
  ASSERT_TRUE(found);
  EXPECT_LE(found->images.size(), 14u);
  EXPECT_GE(found->images.size(), 11u);
  transform(block, found->world_from_block);
  EXPECT_LT(worst_centre(block, truth), 2.5);  // 0.5 m, 14 positions, corners
}

TEST(Datum, TwoPositionsOrOneLineGiveNone) {
  Block block = test_block({.rows = 1, .columns = 8});
  EXPECT_FALSE(datum(block));
  for (auto& [id, image] : block.images) {
    const double along = centre_of(pose_of(block, id)).x();
    image.position = PositionPrior{{along, 2 * along, 50}, Eigen::Vector3d::Constant(0.1)};
  }
  EXPECT_FALSE(datum(block));
}

TEST(Intersect, ExactRaysMeetInTheTruth) {
  const Block block = test_block({.control = 6});
  for (const auto& [id, control] : block.control) {
    const auto met = intersect(sight_lines(block, id));
    if (sight_lines(block, id).size() < 2) continue;
    ASSERT_TRUE(met);
    EXPECT_LT((met->point_in_world - control.position_in_world).norm(), 1e-8);
  }
}

// e' C^-1 e is chi-squared with 3 degrees of freedom: mean 3, standard deviation of the mean of n sqrt(6/n).
TEST(Intersect, CovarianceMatchesTheRealErrors) {
  const Block truth = test_block({.control = 300});
  Random random(2);
  double sum = 0;
  int n = 0;
  for (const auto& [id, control] : truth.control) {
    std::vector<SightLine> lines = sight_lines(truth, id);
    for (SightLine& line : lines) {
      const double du = random.normal(), dv = random.normal();
      line.pixel += 0.5 * Eigen::Vector2d(du, dv);
      line.sigma_px = 0.5;
    }
    const auto met = intersect(lines);
    if (!met || lines.size() < 3) continue;
    const Eigen::Vector3d error = met->point_in_world - control.position_in_world;
    sum += error.dot(met->covariance.ldlt().solve(error));
    ++n;
  }
  ASSERT_GT(n, 200);
  EXPECT_NEAR(sum / n, 3, 4 * std::sqrt(6.0 / n));
}

TEST(Intersect, ParallelOrLonelyRaysGiveNone) {
  const Camera camera = ideal_camera(1000, 1000, 1000);
  const SightLine one{&camera, Rigid3{}, {500, 500}, 1};
  EXPECT_FALSE(intersect(std::vector{one}));
  SightLine other = one;
  other.cam_from_world.translation = {-1, 0, 0};
  EXPECT_FALSE(intersect(std::vector{one, other}));
  other.pixel.x() = 600;  // diverging: they would meet behind
  EXPECT_FALSE(intersect(std::vector{one, other}));
}

}  // namespace
}  // namespace collinea
