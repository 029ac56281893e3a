// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/area_matching.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "collinea/match/census.h"
#include "collinea/match/internal/test_textures.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using testing::image_of;
using testing::shifted_peak;
using testing::WaveTexture;

GreyImage image_with(int width, std::vector<std::uint8_t> grey) {
  GreyImage image;
  image.width = width;
  image.height = static_cast<int>(grey.size()) / width;
  image.data = std::move(grey);
  return image;
}

GreyImage random_image(int width, int height, std::uint64_t seed) {
  Random random(seed);
  GreyImage image(width, height);
  for (auto& grey : image.data) grey = static_cast<std::uint8_t>(random.below(256));
  return image;
}

// The window of 3 x 3 pixels round (row 4, column 5) and what is searched to the left of it (Bolognesi T2).
const GreyImage kReference = image_with(3, {4, 4, 7, 9, 9, 1, 8, 4, 5});
const GreyImage kSearched = image_with(5, {6, 7, 8, 9, 0, 1, 1, 9, 6, 9, 5, 7, 8, 9, 0});

// Values at disparities 0, 1, 2: the window's middle is at columns 3, 2, 1 of kSearched.
std::vector<double> values_of(Similarity method) {
  const auto surface = correlation_surface(kReference, {1, 1}, 1, kSearched, {2, 1}, 1, method);
  EXPECT_EQ(surface.values.width, 3);
  EXPECT_EQ(surface.left, 1);
  return {surface.values.at(2, 0), surface.values.at(1, 0), surface.values.at(0, 0)};
}

TEST(AreaMatching, DifferencesOfBolognesiT2) {
  EXPECT_EQ(values_of(Similarity::kSsd), (std::vector<double>{213, 151, 233}));
  EXPECT_EQ(values_of(Similarity::kSad), (std::vector<double>{37, 31, 39}));
}

TEST(AreaMatching, CorrelationOfBolognesiT2) {  // with the window's mean taken off
  const auto ncc = values_of(Similarity::kNcc);
  EXPECT_NEAR(ncc[0], -0.201325, 1e-6);
  EXPECT_NEAR(ncc[1], -0.193037, 1e-6);
  EXPECT_NEAR(ncc[2], -0.799777, 1e-6);
}

TEST(AreaMatching, CorrelationWithoutTheMeansOfBolognesiT2) {  // six digits are printed
  const auto cosine = values_of(Similarity::kCosine);
  EXPECT_NEAR(cosine[0], 0.756018, 5e-7);
  EXPECT_NEAR(cosine[1], 0.837635, 5e-7);
  EXPECT_NEAR(cosine[2], 0.676227, 5e-7);
}

// A factor does nothing to it, brightness does: of (10, 20) with (20, 40) it is 1, with (110, 120) that of the angle.
TEST(AreaMatching, CorrelationWithoutTheMeansIsBlindToContrastAlone) {
  const GreyImage window = image_with(3, {10, 20, 30, 40, 50, 60, 70, 80, 90});
  GreyImage doubled = window, brighter = window;
  double product = 0, own = 0, other = 0;
  for (std::size_t i = 0; i < window.data.size(); ++i) {
    doubled.data[i] = static_cast<std::uint8_t>(2 * window.data[i]);
    brighter.data[i] = static_cast<std::uint8_t>(100 + window.data[i]);
    product += double(window.data[i]) * brighter.data[i];
    own += double(window.data[i]) * window.data[i];
    other += double(brighter.data[i]) * brighter.data[i];
  }
  const auto of = [&](const GreyImage& image) {
    return correlation_surface(window, {1, 1}, 1, image, {1, 1}, 0, Similarity::kCosine).values.at(0, 0);
  };
  EXPECT_NEAR(of(doubled), 1, 1e-7);  // single precision
  EXPECT_NEAR(of(brighter), product / std::sqrt(own * other), 1e-7);
  EXPECT_LT(of(brighter), 0.97);
  EXPECT_EQ(of(GreyImage(3, 3, 1, 0)), 0);  // of black there is none
}

TEST(AreaMatching, ImageDistancesAreRootsOfTheSquaredDifferences) {  // Karfis 4.3.2
  EXPECT_NEAR(values_of(Similarity::kD)[0], std::sqrt(213.0), 1e-5);
  EXPECT_NEAR(values_of(Similarity::kDn)[1], std::sqrt(151.0 / 9), 1e-6);
}

// Bolognesi T1: Moravec's sums of the pixel in row 4, column 3 (from 1) are the squared differences of its window of
// 3 x 3 pixels to those around it, x to the right and y up; their minimum is 130050.
TEST(AreaMatching, ShiftsOfBolognesiT1) {
  GreyImage image(6, 6, 1, 255);
  for (int y = 3; y < 6; ++y)
    for (int x = 0; x < 3; ++x) image.at(x, y) = 0;
  const struct {
    int x, y;
    float sum;
  } printed[] = {{1, 1, 195075},   {1, 0, 130050},  {1, -1, 195075}, {0, -1, 130050},
                 {-1, -1, 325125}, {-1, 0, 130050}, {-1, 1, 195075}, {0, 1, 130050}};
  const auto sums = correlation_surface(image, {2, 3}, 1, image, {2, 3}, 1, Similarity::kSsd);
  for (const auto& shift : printed)
    EXPECT_EQ(sums.values.at(2 + shift.x - sums.left, 3 - shift.y - sums.top), shift.sum) << shift.x << ' ' << shift.y;
}

// Karfis W1: nine pixels differ by 9 * 255^2 = 585225 at most (520200 is printed as the maximum).
TEST(AreaMatching, LargestSumOfKarfisW1) {
  const GreyImage black(3, 3, 1, 0), white(3, 3, 1, 255);
  EXPECT_EQ(correlation_surface(black, {1, 1}, 1, white, {1, 1}, 0, Similarity::kSsd).values.at(0, 0), 585225);
}

// Bolognesi T3: ranks 2 and 4; census 00000011 (printed with 7 digits) and 11010001, 4 digits apart.
TEST(AreaMatching, RankAndCensusOfBolognesiT3) {
  const GreyImage first = image_with(3, {89, 63, 72, 67, 55, 64, 58, 51, 49});
  const GreyImage second = image_with(3, {22, 24, 34, 25, 30, 35, 45, 39, 29});
  const auto rank = correlation_surface(first, {1, 1}, 0, second, {1, 1}, 0, Similarity::kRank, 3);
  EXPECT_EQ(rank.values.at(0, 0), 2);
  EXPECT_EQ(darker_neighbours(first, 1, 1, 1), 0b00000011u);
  EXPECT_EQ(darker_neighbours(second, 1, 1, 1), 0b11010001u);
  // Of a window against one without a darker neighbour: its own rank.
  const GreyImage flat(3, 3, 1, 9);
  for (const auto& [window, own] : {std::pair{&first, 2}, {&second, 4}})
    EXPECT_EQ(correlation_surface(*window, {1, 1}, 0, flat, {1, 1}, 0, Similarity::kRank, 3).values.at(0, 0), own);
  const auto census = correlation_surface(first, {1, 1}, 0, second, {1, 1}, 0, Similarity::kCensus, 3);
  EXPECT_EQ(census.values.at(0, 0), 4);
}

TEST(AreaMatching, EveryProcessorSumsUpTheSame) {
  const GreyImage image = random_image(40, 37, 3), other = random_image(90, 70, 4);
  for (const int half : {0, 1, 7, 10})
    for (const std::int64_t target : testing::processor_targets()) {
      const testing::OnTarget chosen(target);
      const auto surface = correlation_surface(image, {20, 18}, half, other, {50, 30}, 29, Similarity::kSsd);
      for (int y = 0; y < surface.values.height; y += 7)
        for (int x = 0; x < surface.values.width; ++x) {
          double ssd = 0;
          for (int v = -half; v <= half; ++v)
            for (int u = -half; u <= half; ++u)
              ssd += std::pow(image.at(20 + u, 18 + v) - other.at(surface.left + x + u, surface.top + y + v), 2);
          ASSERT_EQ(surface.values.at(x, y), static_cast<float>(ssd)) << half;
        }
    }
}

TEST(AreaMatching, CorrelationIsBlindToBrightnessAndContrastByKarfisW8) {
  const WaveTexture texture(5);
  const GreyImage left = image_of(61, 61, texture);
  const GreyImage right = image_of(61, 61, [&](const Vector2d& at) { return 0.5 * texture(at) + 60; });
  const auto surface = correlation_surface(left, {30, 30}, 10, right, {30, 30}, 5, Similarity::kNcc);
  EXPECT_GT(surface.values.at(5, 5), 0.999F);
}

// Karfis W13: rows of olive trees are alike; every tree is a candidate, and none is decisively the best.
TEST(AreaMatching, ARepetitiveGroveIsAmbiguousInKarfisW13) {
  const auto grove = [](const Vector2d& at) {
    const double x = std::remainder(at.x(), 14), y = std::remainder(at.y(), 14);
    return 160 - 90 * std::exp(-(x * x + y * y) / 18);
  };
  const GreyImage left = image_of(121, 121, grove, 2, 1), right = image_of(121, 121, grove, 2, 2);
  const Vector2d at(60.5, 60.5);
  const auto found = match_area(left, at, right, at, {});
  EXPECT_EQ(found.outcome, AreaOutcome::kAmbiguous);
  EXPECT_GE(found.candidates.size(), 9);  // 81 px hold five trees of 14 px each way, those at the border perhaps not
  const auto near = match_area(left, at, right, at, {.search_px = 11});  // an expectation better than half a spacing
  ASSERT_TRUE(near.match);
  EXPECT_LT((near.match->position_px - at).norm(), 0.2);
}

// Karfis W13: a homogeneous slab roof shows noise alone, and that of two images has nothing in common: the correlation
// of 441 pixels has a standard deviation of 0.05, far below what is asked for.
TEST(AreaMatching, AHomogeneousRoofHasNoCandidateInKarfisW13) {
  const auto roof = [](const Vector2d&) { return 140.0; };
  const Vector2d at(60.5, 60.5);
  const auto found = match_area(image_of(121, 121, roof, 2, 1), at, image_of(121, 121, roof, 2, 2), at, {});
  EXPECT_EQ(found.outcome, AreaOutcome::kNoCandidate);
}

// Karfis W13: corners of buildings match wrongly, at 0.8 too. A point of the ground, 6 px from both walls, is hidden in
// the right image by the roof, which stands 12 px farther left and 12 px higher there. The window of 21 px holds more
// of the bright roof's edges than of the ground: it finds the roof's corner, 17 px from the truth, and comes back. A
// window of 11 px that holds the ground alone finds nothing: what it shows is not there, and 121 pixels of another
// texture with waves of 3 to 6 px, some 25 independent values, do not correlate by 0.8 by chance.
TEST(AreaMatching, AnOccludedCornerOfABuildingIsMatchedToItsRoofInKarfisW13) {
  const WaveTexture ground(3, 3, 6), roof(4, 3, 6);
  const auto town = [&](const Vector2d& at, const Vector2d& corner) {
    const bool is_roof = at.x() > corner.x() && at.y() > corner.y();
    return is_roof ? 0.3 * (roof(at - corner) - 128) + 200 : 0.3 * (ground(at) - 128) + 80;
  };
  const Vector2d corner(66.5, 66.5), moved = corner - Vector2d(12, 12), at(60.5, 60.5);
  const GreyImage left = image_of(
                      121, 121, [&](const Vector2d&p) { return town(p, corner); }, 2, 1),
                  right = image_of(
                      121, 121, [&](const Vector2d&p) { return town(p, moved); }, 2, 2);
  const auto found = match_area(left, at, right, at, {.search_px = 61});
  ASSERT_TRUE(found.match) << word_of(found.outcome);
  EXPECT_GT(found.match->value, 0.8);
  EXPECT_LT((found.match->position_px - (at - Vector2d(12, 12))).norm(), 1);
  EXPECT_EQ(match_area(left, at, right, at, {.template_px = 11, .search_px = 61}).outcome, AreaOutcome::kNoCandidate);
}

TEST(AreaMatching, EveryMethodFindsTheShift) {
  const WaveTexture texture(7);
  const Vector2d shift(6.3, -4.6);
  const GreyImage left = image_of(121, 121, texture, 1, 1);
  const GreyImage right = image_of(
      121, 121, [&](const Vector2d& at) { return texture(at - shift); }, 1, 2);
  const Vector2d at(60.9, 59.2);
  for (const auto& method : kSimilarityWords) {
    const auto found = match_area(left, at, right, at, {.method = method.value, .search_px = 61});
    ASSERT_TRUE(found.match) << method.word;
    EXPECT_LT((found.match->position_px - at - shift).norm(), 0.15) << method.word;
    EXPECT_LT(*found.match->returned_px, 0.3);
  }
}

// e' C^-1 e is chi-squared with two degrees of freedom. A paraboloid over whole pixels flattens the peak and so states
// a little too much; with waves of 16 pixels and more that is little.
TEST(AreaMatching, StandardDeviationsOfThePeakAreThoseOfTheErrors) {
  constexpr int kTrials = 300;
  constexpr double kNoise_grey = 3;
  for (const Similarity method : {Similarity::kNcc, Similarity::kSsd, Similarity::kSad}) {
    double sum = 0;
    int count = 0;
    Random random(21);
    for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
      const WaveTexture texture(300 + trial % 30, 10, 30, 6);
      const auto found = shifted_peak(texture, 27, kNoise_grey, trial, random, method);
      if (!found) continue;
      ++count;
      sum += found->error_px.dot(found->peak.covariance_px2->inverse() * found->error_px);
    }
    EXPECT_GT(count, 0.97 * kTrials) << word_of(method);
    // Of sad the covariance states too much (0.59 here): absolute differences of whole grey values round the peak off.
    EXPECT_LT(sum / count / 2, 1.25) << word_of(method);
    EXPECT_GT(sum / count / 2, method == Similarity::kSad ? 0.45 : 0.75) << word_of(method);
  }
}

TEST(AreaMatching, RepeatedTextureIsAmbiguous) {
  const auto grid = [](const Vector2d& at) { return 128 + 50 * std::sin(at.x() / 2) + 50 * std::cos(at.y() / 2.2); };
  const GreyImage image = image_of(161, 161, grid);
  const Vector2d middle(80.5, 80.5);
  const auto found = match_area(image, middle, image, middle, {});
  EXPECT_EQ(found.outcome, AreaOutcome::kAmbiguous);
  EXPECT_GT(found.candidates.size(), 5u);
  EXPECT_EQ(match_area(image, middle, image, middle, {.search_px = 29}).outcome, AreaOutcome::kFound);  // narrow enough
}

TEST(AreaMatching, WhatIsNotThereIsNotFound) {
  const GreyImage left = image_of(121, 121, WaveTexture(1)), right = image_of(121, 121, WaveTexture(2));
  const Vector2d middle(60.5, 60.5);
  EXPECT_EQ(match_area(left, middle, right, middle, {}).outcome, AreaOutcome::kNoCandidate);
  const GreyImage grey(121, 121, 1, 90);
  EXPECT_EQ(match_area(grey, middle, grey, middle, {}).outcome, AreaOutcome::kNoCandidate);
  EXPECT_EQ(match_area(left, {3, 3}, right, middle, {}).outcome, AreaOutcome::kOutside);
  EXPECT_EQ(match_area(left, middle, right, {500, 0}, {}).outcome, AreaOutcome::kOutside);
  EXPECT_EQ(match_area(left, {std::nan(""), 0}, right, middle, {}).outcome, AreaOutcome::kOutside);
}

TEST(AreaMatching, AMaximumAtTheBorderOfTheSearchIsRefused) {
  const WaveTexture texture(7);
  const GreyImage left = image_of(121, 121, texture);
  const GreyImage right = image_of(121, 121, [&](const Vector2d& at) { return texture(at - Vector2d(6, 0)); });
  const Vector2d middle(60.5, 60.5);
  EXPECT_EQ(match_area(left, middle, right, middle, {.search_px = 33}).outcome, AreaOutcome::kAtBorder);
  EXPECT_EQ(match_area(left, middle, right, middle, {.search_px = 35}).outcome, AreaOutcome::kFound);
}

// The left image shows a texture twice: what the first shows matches the right image, but that leads back to the other.
TEST(AreaMatching, AMatchThatDoesNotComeBackIsRefused) {
  const WaveTexture texture(9);
  const auto twice = [&](double noise, double x) { return noise * std::sin(x * 1.7); };
  const GreyImage left = image_of(201, 61, [&](const Vector2d& at) {
    return at.x() < 100 ? texture(at) + twice(12, at.x() + 2 * at.y()) : texture(at - Vector2d(100, 0));
  });
  const GreyImage right = image_of(101, 61, texture);
  const AreaOptions options{.template_px = 21, .search_px = 301, .threshold = 0.5, .decisive_ratio = 1};
  EXPECT_EQ(match_area(left, {50.5, 30.5}, right, {50.5, 30.5}, options).outcome, AreaOutcome::kNotReturned);
  EXPECT_EQ(match_area(left, {150.5, 30.5}, right, {50.5, 30.5}, options).outcome, AreaOutcome::kFound);
}

}  // namespace
}  // namespace collinea
