// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/tie_weights.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

const Run kRun;
constexpr int kDegrees = 3;
constexpr double kScale_px = 0.3;

// A third of the points keeps two rays. Errors are normal (degrees 0) or Student's.
Block measured_block(const Block& truth, int degrees, std::uint64_t seed) {
  Block block = truth;
  Random random(seed, 5);
  PointId last{0};
  int rays = 0;
  std::erase_if(block.observations, [&](const Observation& seen) {
    rays = seen.point == last ? rays + 1 : 1;
    last = seen.point;
    return seen.point.value % 3 == 0 && rays > 2;
  });
  for (Observation& seen : block.observations) {
    double chi2 = 0;
    for (int k = 0; k < degrees; ++k) chi2 += std::pow(random.normal(), 2);
    const double u = random.normal(), v = random.normal();
    const double scale_px = degrees > 0 ? kScale_px * std::sqrt(degrees / chi2) : kScale_px;
    seen.pixel += scale_px * Eigen::Vector2d(u, v);
    seen.sigma_px = 1;
  }
  return block;
}

AdjustScope between_fixed(const Block& block) {
  return {.fixed_images = {block.images.begin()->first, block.images.rbegin()->first}};
}

double squared_centre_error(const Adjusted& adjusted, const Block& truth) {
  double squares = 0;
  for (const auto& [id, pose] : adjusted.cam_from_world)
    squares += (centre_of(pose) - centre_of(pose_of(truth, id))).squaredNorm();
  return squares;
}

// The variance of estimates of greatest likelihood of Student's distribution in two dimensions is
// (nu + 4) / (nu + 2) s^2 N^-1, of least squares nu / (nu - 2) s^2 N^-1: with nu = 3 the ratio is 1.4 / 3 = 0.47.
// Taking the weights as known, covariances say s^2 N^-1: errors are 1.4 times as large in variance.
TEST(TieWeights, OfStudentErrorsAreNearerToTheTruthThanLeastSquares) {
  double weighted = 0, alike = 0, stated = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Block truth = test_block({.rows = 2, .columns = 4, .points = 300, .seed = seed});
    const Block block = measured_block(truth, kDegrees, seed);
    const AdjustScope scope = between_fixed(block);
    const auto plain = adjust(block, scope, testing::plain(), kRun);
    Block by_errors = block;
    const auto found = weigh_ties(by_errors, scope, testing::plain(), kRun);
    ASSERT_TRUE(plain && found);
    EXPECT_TRUE(found->converged);
    // The errors of other rays of a point make residuals more alike to normal ones: scale and degrees of freedom come
    // out larger, of points with three rays and more by less than a third and twice.
    EXPECT_GT(found->scale, 0.9 * kScale_px);
    EXPECT_LT(found->scale, 1.33 * kScale_px);
    EXPECT_GT(found->degrees_of_freedom, 2);
    EXPECT_LT(found->degrees_of_freedom, 7);
    const auto adjusted = examine(by_errors, scope, testing::examined(), kRun);
    ASSERT_TRUE(adjusted);
    EXPECT_NEAR(adjusted->sigma0, 1, 0.05);
    weighted += squared_centre_error(*adjusted, truth);
    alike += squared_centre_error(*plain, truth);
    for (const auto& [id, covariance] : adjusted->pose_covariance)
      stated += covariance.bottomRightCorner<3, 3>().trace();
  }
  EXPECT_GT(weighted / alike, 0.4);
  EXPECT_LT(weighted / alike, 0.65);
  EXPECT_NEAR(weighted / stated, 1.4, 0.2);
}

TEST(TieWeights, OfNormalErrorsAreAsStated) {
  int changed = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Block truth = test_block({.rows = 2, .columns = 4, .points = 300, .seed = seed});
    Block block = measured_block(truth, 0, seed);
    const Block before = block;
    const auto found = weigh_ties(block, between_fixed(block), testing::plain(), kRun);
    ASSERT_TRUE(found);
    for (std::size_t i = 0; i < block.observations.size(); ++i)
      if (block.observations[i].sigma_px != before.observations[i].sigma_px) {
        ++changed;
        break;
      }
  }
  EXPECT_EQ(changed, 0);  // called Student's by chance: one of a thousand, of each class of points
}

TEST(TieWeights, AFewRaysStayAsTheyAre) {
  Block block = test_block({.rows = 1, .columns = 3, .points = 30, .sigma_px = 0.5});
  const Block before = block;
  const auto found = weigh_ties(block, between_fixed(block), testing::plain(), kRun);
  ASSERT_TRUE(found);
  EXPECT_TRUE(std::isinf(found->degrees_of_freedom));
  for (std::size_t i = 0; i < block.observations.size(); ++i)
    EXPECT_EQ(block.observations[i].sigma_px, before.observations[i].sigma_px);
}

TEST(TieWeights, ThreadsDoNotChangeABit) {
  const Block truth = test_block({.rows = 2, .columns = 4, .points = 300});
  Block a = measured_block(truth, kDegrees, 1), b = a;
  collinea::Run one, three;
  one.threads = 1;
  three.threads = 3;
  ASSERT_TRUE(weigh_ties(a, between_fixed(a), testing::plain(), one));
  ASSERT_TRUE(weigh_ties(b, between_fixed(b), testing::plain(), three));
  for (std::size_t i = 0; i < a.observations.size(); ++i)
    ASSERT_EQ(a.observations[i].sigma_px, b.observations[i].sigma_px);
}

}  // namespace
}  // namespace collinea
