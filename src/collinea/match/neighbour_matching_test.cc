// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/neighbour_matching.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/match/internal/test_textures.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using testing::image_of;
using testing::WaveTexture;

// A wall of tiles, 14 px apart and alike, among stones of their own texture; the right image shows all 5.4 px farther.
// Tiles fit themselves a tile farther as well: alone each is ambiguous, the stones around say which it is.
const Vector2d kShift(5.4, -2.7);
double wall(const Vector2d& at) {
  static const WaveTexture stones(4);
  const bool is_tiled = at.x() > 90 && at.x() < 150 && at.y() > 70 && at.y() < 130;
  if (!is_tiled) return stones(at);
  const double x = std::remainder(at.x(), 14), y = std::remainder(at.y(), 14);
  return 170 - 110 * std::exp(-(x * x + y * y) / 16);
}

struct Wall {
  GreyImage left = image_of(240, 200, wall, 2, 1);
  GreyImage right = image_of(
      240, 200, [](const Vector2d& at) { return wall(at - kShift); }, 2, 2);
  std::vector<AreaPoint> points;
  std::vector<bool> is_tile;

  Wall() {
    for (double y = 40.5; y < 165; y += 12)
      for (double x = 40.5; x < 205; x += 12) {
        points.push_back({{x, y}, Vector2d(x, y)});
        // Windows of 11 px that see tiles alone.
        is_tile.push_back(std::abs(x - 120) < 20 && std::abs(y - 100) < 20);
      }
  }
};

TEST(NeighbourMatching, NeighboursTellTilesApartByEveryMeasure) {
  const Wall scene;
  for (const auto& method : kSimilarityWords) {
    const AreaOptions options{.method = method.value, .template_px = 11, .search_px = 61};
    const auto matches = match_areas(scene.left, scene.right, scene.points, options, {}, {.threads = 2});
    ASSERT_EQ(matches.size(), scene.points.size());
    int tiles = 0, found_tiles = 0, alone = 0, found = 0, wrong = 0;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const AreaMatching by_itself =
          match_area(scene.left, scene.points[i].position_px, scene.right, scene.points[i].expected_px, options);
      if (scene.is_tile[i]) {
        ++tiles;
        alone += by_itself.outcome == AreaOutcome::kFound;
      }
      if (!matches[i].match) continue;
      ++found;
      found_tiles += scene.is_tile[i];
      // Half a spacing is another tile; area matching itself is good to a fifth of a pixel, at an edge of tiles to one.
      wrong += (matches[i].match->position_px - scene.points[i].position_px - kShift).norm() > 2;
      EXPECT_GT(matches[i].likeness, 0);
      EXPECT_GE(matches[i].probability, RelaxationOptions{}.least_probability);
    }
    EXPECT_GE(tiles, 9) << method.word;
    EXPECT_EQ(alone, 0) << method.word;
    EXPECT_EQ(found_tiles, tiles) << method.word;
    EXPECT_GT(found, 0.9 * double(matches.size())) << method.word;
    EXPECT_EQ(wrong, 0) << method.word;
  }
}

TEST(NeighbourMatching, ThreadsDoNotMatter) {
  const Wall scene;
  const auto one = match_areas(scene.left, scene.right, scene.points, {}, {}, {.threads = 1});
  const auto two = match_areas(scene.left, scene.right, scene.points, {}, {}, {.threads = 2});
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].outcome, two[i].outcome);
    EXPECT_EQ(one[i].probability, two[i].probability);
    if (one[i].match) {
      EXPECT_EQ(one[i].match->position_px, two[i].match->position_px);
    }
  }
}

TEST(NeighbourMatching, SaysWhyThereIsNoMatch) {
  const GreyImage left = image_of(121, 121, WaveTexture(1)), other = image_of(121, 121, WaveTexture(2));
  const Vector2d middle(60.5, 60.5);
  EXPECT_TRUE(match_areas(left, left, {}, {}, {}, {}).empty());
  const std::vector<AreaPoint> points = {{middle, middle}, {{2, 2}, middle}, {middle, {5000, 0}}};
  const auto nothing = match_areas(left, other, points, {}, {}, {});
  EXPECT_EQ(nothing[0].outcome, AreaOutcome::kNoCandidate);
  EXPECT_EQ(nothing[1].outcome, AreaOutcome::kOutside);
  EXPECT_EQ(nothing[2].outcome, AreaOutcome::kOutside);
  // A perfect match that nobody bears out, and two points for one position.
  const std::vector<AreaPoint> alone = {{middle, middle}};
  EXPECT_EQ(match_areas(left, left, alone, {}, {}, {})[0].outcome, AreaOutcome::kUndecided);
  std::vector<AreaPoint> twice;
  for (int i = 0; i < 9; ++i) {
    const Vector2d at(30.5 + 30 * (i % 3), 30.5 + 30 * (i / 3));
    twice.push_back({at, at});
  }
  twice.push_back({middle, middle});
  const auto taken = match_areas(left, left, twice, {}, {}, {});
  EXPECT_EQ(taken[4].outcome, AreaOutcome::kFound);
  EXPECT_EQ(taken.back().outcome, AreaOutcome::kTaken);
  // The extremum lies at the border of what is searched.
  std::vector<AreaPoint> off;
  for (const AreaPoint& point : twice) off.push_back({point.position_px, point.position_px + Vector2d(3, 0)});
  const AreaOptions narrow{.search_px = 27};
  EXPECT_EQ(match_areas(left, left, off, narrow, {}, {})[0].outcome, AreaOutcome::kAtBorder);
}

// Constant windows: every difference is the same, nothing is alike.
TEST(NeighbourMatching, LikenessIsOnOneScale) {
  const WaveTexture texture(3);
  const GreyImage image = image_of(121, 121, texture);
  for (const auto& method : kSimilarityWords) {
    const auto surface = correlation_surface(image, {60, 60}, 10, image, {60, 60}, 20, method.value);
    const auto all = likenesses(
        surface, candidates(surface, 3, method.value == Similarity::kNcc ? std::optional(-1.0) : std::nullopt));
    ASSERT_FALSE(all.empty()) << method.word;
    EXPECT_NEAR(all.front(), 1, 1e-6) << method.word;  // itself
    for (const double each : all) EXPECT_TRUE(each >= 0 && each <= 1) << method.word;
    if (method.value == Similarity::kNcc) continue;
    const GreyImage flat(61, 61, 1, 90);
    const auto nothing = correlation_surface(flat, {30, 30}, 5, flat, {30, 30}, 5, method.value);
    for (const double each : likenesses(nothing, candidates(nothing, 2, std::nullopt))) EXPECT_EQ(each, 0);
  }
}

// Windows of 441 independent grey values of 128 with a standard deviation of 20. By cosine every position is like every
// other (0.976), as likeness none is: q is a mean of 441 products of two grey values (1 / n) and squares of one (1 / 2
// n) about the median, its standard deviation is sqrt(1.5 / 441) of it. Five of them, of 1681 positions. Of windows
// with half of their variance in common r is 0.5, and q errs by as large a part of 0.5.
TEST(NeighbourMatching, LikenessByCosineIsThatOfTheCorrelation) {
  const Vector2i middle(60, 60);
  const auto best_of = [&](const GreyImage& left, const GreyImage& right, Similarity method) {
    const auto surface = correlation_surface(left, middle, 10, right, middle, 20, method);
    const auto all = candidates(surface, 3, std::optional(-1.0));
    return std::pair(all.front(), likenesses(surface, all).front());
  };
  const auto grey = [](const Vector2d&) { return 128.0; };
  const GreyImage left = image_of(121, 121, grey, 20, 1), other = image_of(121, 121, grey, 20, 2);
  const auto [chance, likeness] = best_of(left, other, Similarity::kCosine);
  EXPECT_GT(chance.value, 0.9);
  EXPECT_LT(likeness, 5 * std::sqrt(1.5 / 441));
  const auto common = [&](const Vector2d& at) { return double(left.at(int(at.x()), int(at.y()))); };
  const GreyImage one = image_of(121, 121, common, 20, 3), two = image_of(121, 121, common, 20, 4);
  const auto [same, by_cosine] = best_of(one, two, Similarity::kCosine);
  EXPECT_EQ(same.pixel, middle);
  EXPECT_NEAR(by_cosine, best_of(one, two, Similarity::kNcc).second, 5 * 0.5 * std::sqrt(1.5 / 441));
}

}  // namespace
}  // namespace collinea
