// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/local_matching.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "collinea/dense/internal/local_kernels.h"
#include "collinea/dense/internal/test_pair.h"
#include "collinea/math/random.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

using test::DisparityErrors;
using test::TestPair;

Result<DisparityMap> matched(const TestPair& pair, Similarity similarity, const Run& run = {}) {
  return match_locally(pair.image_of(true), pair.image_of(false), {0, 40}, {.similarity = similarity}, {}, run);
}

bool is_empty(const FloatImage& disparity) {
  return std::all_of(disparity.data.begin(), disparity.data.end(), [](float d) { return std::isnan(d); });
}

bool is_same(const DisparityMap& one, const DisparityMap& other) {
  const auto same = [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  return std::equal(one.disparity.data.begin(), one.disparity.data.end(), other.disparity.data.begin(), same) &&
         std::equal(one.sigma.data.begin(), one.sigma.data.end(), other.sigma.data.begin(), same);
}

GreyImage random_image(int width, int height, std::uint64_t seed) {
  Random random(seed);
  GreyImage image(width, height);
  for (auto& grey : image.data) grey = std::uint8_t(1 + random.below(255));
  return image;
}

TEST(LocalMatching, EveryCostFindsAPlane) {
  for (const auto& [similarity, word, meaning] : kSimilarityWords)
    for (const double slope : {0.0, 0.05}) {
      const TestPair pair{.slope = slope, .noise = 2};
      const auto map = matched(pair, similarity);
      ASSERT_TRUE(map) << map.error().message;
      const DisparityErrors e = errors_of(pair, *map);
      EXPECT_GT(e.measured, 0.95 * e.possible) << word << slope;
      EXPECT_EQ(e.bad, 0) << word << slope;
      EXPECT_LT(e.rms, 0.15) << word << slope;  // measured: 0.05 (ssd) to 0.12 (rank)
    }
}

// Windows of 9 pixels reach 4 across the edges of the square, whose circumference is 200: 1600 pixels see both sides.
TEST(LocalMatching, EveryCostFindsAStep) {
  for (const auto& [similarity, word, meaning] : kSimilarityWords) {
    const TestPair pair{.at_left = 10, .square = 24, .noise = 2};
    const auto map = matched(pair, similarity);
    ASSERT_TRUE(map) << map.error().message;
    const DisparityErrors e = errors_of(pair, *map);
    EXPECT_GT(e.measured, 0.9 * e.possible) << word;
    EXPECT_LT(e.bad, 180) << word;  // measured: 56 (census) to 147 (ncc)
    int before = 0, behind = 0;     // farther from the edges than a window reaches
    for (int y = 40; y < 80; ++y) {
      for (int x = 85; x < 125; ++x) before += std::abs(map->disparity.at(x, y) - 24) < 0.5f;
      for (int x = 140; x < 180; ++x) behind += std::abs(map->disparity.at(x, y) - 10) < 0.5f;
    }
    EXPECT_GT(before, 0.97 * 1600) << word;
    EXPECT_GT(behind, 0.97 * 1600) << word;
  }
}

// The best of correlation_surface() along the row, by whole pixels: windows of random pixels, that differ everywhere.
TEST(LocalMatching, CostsAreThoseOfAreaMatching) {
  constexpr int kHigh = 12, kHalf = 3, kShift = 5;
  const GreyImage right = random_image(70, 30, 3), noise = random_image(70, 30, 4);
  GreyImage left(70, 30);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 70; ++x)
      left.at(x, y) = std::uint8_t((right.at(std::max(x - kShift, 0), y) + noise.at(x, y)) / 2);
  for (const auto& [similarity, word, meaning] : kSimilarityWords)
    for (const int neighbourhood : {3, 5, 7}) {
      const auto map = match_locally(
          left, right, {0, kHigh},
          {.similarity = similarity, .window_px = 2 * kHalf + 1, .neighbourhood_px = neighbourhood}, {100, 0}, {});
      ASSERT_TRUE(map) << map.error().message;
      int compared = 0;
      for (int y = kHalf; y < 30 - kHalf; y += 4)
        for (int x = kHigh + kHalf; x < 70 - kHalf; x += 3) {
          if (std::isnan(map->disparity.at(x, y))) continue;
          const CorrelationSurface surface =
              correlation_surface(left, {x, y}, kHalf, right, {x, y}, kHigh, similarity, neighbourhood);
          ASSERT_LE(surface.top, y);
          double best = 0;
          int disparity = -1;
          for (int d = 0; d <= kHigh; ++d) {
            const double value = surface.values.at(x - d - surface.left, y - surface.top);
            const double cost = is_larger_better(similarity) ? -value : value;
            if (disparity < 0 || cost < best) best = cost, disparity = d;
          }
          EXPECT_LE(std::abs(double(map->disparity.at(x, y)) - disparity), 0.5) << word << x << ' ' << y;
          ++compared;
        }
      EXPECT_GT(compared, 60) << word;
    }
}

TEST(LocalMatching, SsdAndItsRootsGiveTheSame) {
  const TestPair pair{.slope = 0.05, .noise = 4};
  const auto ssd = matched(pair, Similarity::kSsd), d = matched(pair, Similarity::kD),
             dn = matched(pair, Similarity::kDn);
  ASSERT_TRUE(ssd && d && dn);
  EXPECT_TRUE(is_same(*ssd, *d));
  EXPECT_TRUE(is_same(*ssd, *dn));
}

TEST(LocalMatching, CorrelationRankAndCensusAreBlindToBrightnessAndContrast) {
  const TestPair pair{.slope = 0.05, .noise = 1};
  GreyImage right = pair.image_of(false);
  for (auto& grey : right.data) grey = std::uint8_t(40 + 0.7 * grey);
  for (const Similarity similarity : {Similarity::kNcc, Similarity::kRank, Similarity::kCensus}) {
    const auto map = match_locally(pair.image_of(true), right, {0, 40}, {.similarity = similarity}, {}, {});
    ASSERT_TRUE(map) << map.error().message;
    const DisparityErrors e = errors_of(pair, *map);
    EXPECT_GT(e.measured, 0.9 * e.possible) << word_of(similarity);
    EXPECT_EQ(e.bad, 0) << word_of(similarity);
  }
}

TEST(LocalMatching, WithoutTextureThereIsNothing) {
  for (const auto& [similarity, word, meaning] : kSimilarityWords) {
    const auto map =
        match_locally(GreyImage(80, 40, 1, 90), GreyImage(80, 40, 1, 90), {0, 31}, {.similarity = similarity}, {}, {});
    ASSERT_TRUE(map) << map.error().message;
    EXPECT_TRUE(is_empty(map->disparity)) << word;
    // Some window of the right image is always the best.
    const auto of_left_alone = match_locally(GreyImage(80, 40, 1, 90), random_image(80, 40, 5), {0, 31},
                                             {.similarity = similarity}, {100, 0}, {});
    ASSERT_TRUE(of_left_alone);
    EXPECT_TRUE(is_empty(of_left_alone->disparity)) << word;
  }
}

// Stripes 8 pixels apart: of 0 to 31 every eighth disparity is as good.
TEST(LocalMatching, RepeatedTextureIsLeftOut) {
  constexpr std::array<std::uint8_t, 8> kStripe = {90, 120, 180, 150, 140, 60, 30, 70};
  GreyImage image(120, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 120; ++x) image.at(x, y) = kStripe[std::size_t(x % 8)];
  for (const auto& [similarity, word, meaning] : kSimilarityWords) {
    const auto map = match_locally(image, image, {-3, 31}, {.similarity = similarity}, {}, {});
    ASSERT_TRUE(map) << map.error().message;
    int invented = 0;
    for (int y = 10; y < 30; ++y)
      for (int x = 50; x < 100; ++x) invented += !std::isnan(map->disparity.at(x, y));
    EXPECT_EQ(invented, 0) << word;
  }
}

TEST(LocalMatching, WhatOneCameraCannotSeeIsLeftOut) {
  const TestPair pair{.at_left = 10, .square = 24, .noise = 2};
  const GreyImage left = pair.image_of(true), right = pair.image_of(false);
  const auto invented = [&](const LocalLimits& limits) {
    const auto map = match_locally(left, right, {0, 40}, {}, limits, {});
    EXPECT_TRUE(map);
    int count = 0;
    for (int y = 38; y < 82; ++y)
      for (int x = 40; x < 80; ++x) count += !pair.seen_twice(x, y) && !std::isnan(map->disparity.at(x, y));
    return count;
  };
  // Measured: 12 with the check from the right, 399 without.
  EXPECT_LT(invented({}), 30);
  EXPECT_GT(invented({1000, 0}), 300);
}

TEST(LocalMatching, ALargerDecisiveRatioLeavesOutMore) {
  const TestPair pair{.noise = 12};
  const GreyImage left = pair.image_of(true), right = pair.image_of(false);
  int before = pair.width * pair.height;
  for (const double ratio : {1.0, 1.5, 3.0}) {
    const auto map = match_locally(left, right, {0, 40}, {.decisive_ratio = ratio}, {}, {});
    ASSERT_TRUE(map);
    const DisparityErrors e = errors_of(pair, *map);
    EXPECT_LT(e.measured, before) << ratio;
    before = e.measured;
  }
}

TEST(LocalMatching, TheEndOfWhatIsSearchedIsNoMatch) {
  const GreyImage wide = random_image(120, 30, 8);
  GreyImage left(100, 30), right(100, 30);
  for (int y = 0; y < 30; ++y) {
    std::copy_n(wide.row(y), 100, left.row(y));
    std::copy_n(wide.row(y) + 12, 100, right.row(y));
  }
  const auto within = match_locally(left, right, {0, 13}, {}, {}, {}),
             at_end = match_locally(left, right, {0, 12}, {}, {}, {});
  ASSERT_TRUE(within && at_end);
  for (int x = 30; x < 95; ++x) {
    EXPECT_NEAR(within->disparity.at(x, 15), 12, 0.1);
    EXPECT_TRUE(std::isnan(at_end->disparity.at(x, 15)));
  }
}

TEST(LocalMatching, GreyValueZeroIsNothing) {
  const TestPair pair{.at_left = 12};
  GreyImage left = pair.image_of(true), right = pair.image_of(false);
  for (int y = 0; y < pair.height; ++y) {
    std::fill_n(left.row(y) + 60, 20, std::uint8_t(0));
    std::fill_n(right.row(y) + 120, 20, std::uint8_t(0));  // what the left image shows from column 132 on
  }
  const auto map = match_locally(left, right, {0, 40}, {}, {100, 0}, {});
  ASSERT_TRUE(map);
  for (int y = 20; y < 100; ++y) {
    for (int x = 60; x < 80; ++x) EXPECT_TRUE(std::isnan(map->disparity.at(x, y)));
    for (int x = 20; x < 190; ++x) {
      const float d = map->disparity.at(x, y);
      if (std::isnan(d)) continue;
      EXPECT_FALSE(x - int(std::lround(d)) >= 121 && x - int(std::lround(d)) < 139) << x;  // half a pixel to round
    }
    EXPECT_NEAR(map->disparity.at(100, y), 12, 0.5);
  }
}

// Errors of overlapping windows are alike: of 81 pixels each there are some 240, whose root mean square is sure to 4.6
// %: four of these. What the parabola adds makes errors larger where there is little noise; bounds of sad are bounds
// (area_matching.h).
TEST(LocalMatching, SigmasAreTheErrors) {
  for (const Similarity similarity : {Similarity::kNcc, Similarity::kSsd, Similarity::kSad, Similarity::kCosine})
    for (const double noise : {4.0, 8.0, 12.0}) {
      const TestPair pair{.noise = noise};
      const auto map = matched(pair, similarity);
      ASSERT_TRUE(map) << map.error().message;
      const DisparityErrors e = errors_of(pair, *map);
      if (similarity != Similarity::kSad) {
        EXPECT_NEAR(e.in_sigmas, 1, 0.18) << word_of(similarity) << noise;
      } else {  // measured: 1.20, 0.88 and 0.85: with little noise the parabola's own error shows
        EXPECT_LT(e.in_sigmas, noise > 4 ? 1.05 : 1.3) << noise;
        EXPECT_GT(e.in_sigmas, noise > 4 ? 0.7 : 1) << noise;
      }
    }
}

TEST(LocalMatching, RankAndCensusHaveNoSigmas) {
  const TestPair pair;
  for (const Similarity similarity : {Similarity::kRank, Similarity::kCensus}) {
    const auto map = matched(pair, similarity);
    ASSERT_TRUE(map);
    EXPECT_FALSE(is_empty(map->disparity));
    EXPECT_TRUE(is_empty(map->sigma));
  }
}

TEST(LocalMatching, ThreadsAndVectorsDoNotMatter) {
  const TestPair pair{.at_left = 10, .square = 24, .noise = 3};
  collinea::Run many;
  many.threads = 5;
  for (const Similarity similarity :
       {Similarity::kNcc, Similarity::kSsd, Similarity::kSad, Similarity::kCensus, Similarity::kCosine}) {
    const auto alone = matched(pair, similarity), shared = matched(pair, similarity, many);
    ASSERT_TRUE(alone && shared);
    EXPECT_TRUE(is_same(*alone, *shared)) << word_of(similarity);
    for (const std::int64_t target : testing::processor_targets()) {
      const testing::OnTarget chosen(target);
      const auto other = matched(pair, similarity);
      ASSERT_TRUE(other);
      EXPECT_TRUE(is_same(*alone, *other)) << word_of(similarity) << ' ' << hwy::TargetName(target);
    }
  }
}

TEST(LocalMatching, DisparitiesMayBeNegative) {
  const TestPair pair{.at_left = 12};
  const auto map = match_locally(pair.image_of(false), pair.image_of(true), {-30, 3}, {}, {}, {});
  ASSERT_TRUE(map) << map.error().message;
  for (int x = 20; x < 160; ++x) EXPECT_NEAR(map->disparity.at(x, 60), -12, 0.3);
}

TEST(LocalMatching, OneRowOrPixelIsNoTrouble) {
  const GreyImage wide = random_image(100, 1, 2);
  GreyImage left(80, 1), right(80, 1);
  std::copy_n(wide.row(0), 80, left.row(0));
  std::copy_n(wide.row(0) + 7, 80, right.row(0));
  for (const auto& [similarity, word, meaning] : kSimilarityWords) {
    const auto map = match_locally(left, right, {0, 15}, {.similarity = similarity}, {1, 0}, {});
    ASSERT_TRUE(map) << map.error().message;
    int found = 0;
    for (int x = 20; x < 75; ++x) found += std::abs(map->disparity.at(x, 0) - 7) < 0.5f;
    EXPECT_GT(found, 50) << word;
    for (const int size : {1, 2, 5})
      EXPECT_TRUE(match_locally(GreyImage(size, size, 1, 7), GreyImage(size, size, 1, 7), {0, 3},
                                {.similarity = similarity}, {}, {}))
          << word << size;
  }
}

TEST(LocalMatching, WhatCannotBeMatchedIsRefused) {
  const GreyImage image(40, 30, 1, 100);
  const auto code = [&](const Result<DisparityMap>& result) { return result ? Errc::kNotFound : result.error().code; };
  EXPECT_EQ(code(match_locally({}, {}, {0, 9}, {}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_locally(image, GreyImage(40, 31, 1, 100), {0, 9}, {}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_locally(image, image, {0, 1}, {}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_locally(image, image, {40, 49}, {}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_locally(image, image, {0, 9}, {.window_px = 8}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_locally(image, image, {0, 9}, {.neighbourhood_px = 4}, {}, {})), Errc::kBadInput);
  EXPECT_EQ(code(match_locally(image, image, {0, 9}, {.decisive_ratio = 0.5}, {}, {})), Errc::kBadInput);
}

}  // namespace

namespace dense {
namespace {

TEST(TakeLabel, IsTheBestItsNeighboursAndTheNextBestElsewhere) {
  constexpr int kWidth = 37, kLabels = 19;
  constexpr float kNothing = std::numeric_limits<float>::infinity();
  Random random(31);
  std::array<std::array<float, kWidth + kLocalSlack>, kLabels> costs;
  for (auto& row : costs)
    for (auto& cost : row) cost = random.below(12) == 0 ? kNothing : float(random.below(25));
  std::array<std::array<float, kWidth + kLocalSlack>, 10> rows;
  for (auto& row : rows) row.fill(kNothing);
  rows[1].fill(-1);
  rows[9].fill(-1);
  for (int k = 0; k < kLabels; ++k)
    take_label(costs[std::size_t(k)].data(), k, kWidth,
               {rows[0].data(), rows[1].data(), rows[2].data(), rows[3].data(), rows[4].data(), rows[5].data(),
                rows[6].data(), rows[7].data()},
               {rows[8].data(), rows[9].data()});
  for (std::size_t x = 0; x < kWidth; ++x) {
    const auto cost = [&](int k) { return k < 0 || k >= kLabels ? kNothing : costs[std::size_t(k)][x]; };
    int best = 0;
    for (int k = 1; k < kLabels; ++k)
      if (cost(k) < cost(best)) best = k;
    float second = kNothing;
    for (int k = 0; k < kLabels; ++k)
      if (std::abs(k - best) > 1) second = std::min(second, cost(k));
    EXPECT_EQ(rows[0][x], cost(best));
    EXPECT_EQ(rows[1][x], float(best));
    EXPECT_EQ(rows[2][x], cost(best - 1));
    EXPECT_EQ(rows[3][x], cost(best + 1));
    EXPECT_EQ(rows[4][x], second);
    EXPECT_EQ(rows[8][x], cost(best));
    EXPECT_EQ(rows[9][x], float(best));
  }
}

}  // namespace
}  // namespace dense
}  // namespace collinea
