// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/rank_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "collinea/match/internal/test_textures.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using testing::image_of;
using testing::shifted_peak;
using testing::WaveTexture;

// e' C^-1 e is chi-squared with two degrees of freedom. Above 1 is what the paraboloid over whole pixels adds, as with
// the other measures (the bound is that of their test). Below 1: the images have their noise already, and with as much
// again the peak is flatter, so that sigmas are too large, by no more than a quarter. Rank loses its peak sooner.
TEST(RankCovariance, IsThatOfTheErrors) {
  constexpr int kTrials = 250;
  constexpr double kNoise_grey = 2;
  for (const Similarity method : {Similarity::kRank, Similarity::kCensus}) {
    double sum = 0;
    int count = 0;
    Random random(21);
    for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
      const WaveTexture texture(300 + trial % 30, 8, 24, 8);
      const auto found = shifted_peak(texture, 35, kNoise_grey, trial, random, method);
      if (!found) continue;
      const auto covariance = rank_covariance(found->left, found->middle, 10, found->right, found->best, method, 5);
      if (!covariance) continue;
      ++count;
      sum += found->error_px.dot(covariance->inverse() * found->error_px);
    }
    EXPECT_GT(count, 0.7 * kTrials) << word_of(method);
    EXPECT_LT(sum / count / 2, 1.25) << word_of(method);
    EXPECT_GT(sum / count / 2, 1 / (1.25 * 1.25)) << word_of(method);
  }
}

TEST(RankCovariance, MatchesHaveItAlsoWithAnotherTone) {
  const WaveTexture texture(7);
  const Vector2d shift(3.3, -2.6), at(60.9, 59.2);
  const GreyImage left = image_of(121, 121, texture, 2, 1);
  const GreyImage right = image_of(
      121, 121,
      [&](const Vector2d& p) { return 255 * std::pow(std::clamp(texture(p - shift), 0.0, 255.0) / 255, 0.7); }, 2, 2);
  for (const Similarity method : {Similarity::kRank, Similarity::kCensus}) {
    const AreaOptions options{.method = method, .search_px = 41};
    AreaMatching found = match_area(left, at, right, at, options), again = found;
    add_rank_covariance(left, at, right, options, found);
    add_rank_covariance(left, at, right, options, again);
    ASSERT_TRUE(found.match && found.match->covariance_px2) << word_of(method);
    const Vector2d error = found.match->position_px - at - shift;
    EXPECT_LT(error.dot(found.match->covariance_px2->inverse() * error), 13.8) << word_of(method);  // 0.001
    EXPECT_EQ(*again.match->covariance_px2, *found.match->covariance_px2);                          // no chance
  }
}

TEST(RankCovariance, ThereIsNoneWhereThereIsNoPeak) {
  const GreyImage image = image_of(61, 61, WaveTexture(3), 1, 1), flat(61, 61, 1, 90);
  EXPECT_FALSE(rank_covariance(image, {30, 30}, 10, image, {30, 30}, Similarity::kNcc, 5));
  EXPECT_FALSE(rank_covariance(image, {5, 30}, 10, image, {30, 30}, Similarity::kRank, 5));
  EXPECT_FALSE(rank_covariance(image, {30, 30}, 10, image, {10, 30}, Similarity::kCensus, 5));
  EXPECT_FALSE(rank_covariance(flat, {30, 30}, 10, flat, {30, 30}, Similarity::kCensus, 5));
  // Noise alone: no position is like another, and the best of them is lost with other noise.
  const auto grey = [](const Vector2d&) { return 128; };
  const GreyImage one = image_of(61, 61, grey, 20, 1), two = image_of(61, 61, grey, 20, 2);
  EXPECT_FALSE(rank_covariance(one, {30, 30}, 10, two, {30, 30}, Similarity::kCensus, 5));
}

}  // namespace
}  // namespace collinea
