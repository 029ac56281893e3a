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
      const Vector2d shift(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
      const GreyImage left = image_of(35, 35, texture, kNoise_grey, 2 * trial + 1);
      const GreyImage right = image_of(
          35, 35, [&](const Vector2d& at) { return texture(at - shift); }, kNoise_grey, 2 * trial + 2);
      const Vector2i middle(17, 17);
      const auto surface = correlation_surface(left, middle, 10, right, middle, 3, method);
      const Vector2i best = candidates(surface, 3, std::nullopt).front().pixel;
      const auto peak = subpixel_peak(surface, best);
      if (!peak) continue;
      const auto covariance = rank_covariance(left, middle, 10, right, best, method, 5);
      if (!covariance) continue;
      ++count;
      const Vector2d error = (best - middle).cast<double>() + peak->offset_px - shift;
      sum += error.dot(covariance->inverse() * error);
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
