// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/level_matching.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/dense/level_disparities.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

// Smooth noise between the whole positions of a lattice, at several scales: the texture of ground.
double noise_at(double x, double y, std::uint64_t seed) {
  const auto value = [&](int i, int j) {
    return Random(seed, std::uint64_t(std::uint32_t(i)) << 32 | std::uint32_t(j)).uniform();
  };
  const int i = int(std::floor(x)), j = int(std::floor(y));
  const double u = x - i, v = y - j, a = u * u * (3 - 2 * u), b = v * v * (3 - 2 * v);
  return (1 - b) * ((1 - a) * value(i, j) + a * value(i + 1, j)) +
         b * ((1 - a) * value(i, j + 1) + a * value(i + 1, j + 1));
}

double texture(double x, double y) {
  return 40 + 90 * noise_at(x / 3.1, y / 3.1, 1) + 70 * noise_at(x / 9.7, y / 9.7, 2);
}

double disparity(double x, double y) { return 40 + 0.03 * x + 5 * std::sin(x / 45) * std::cos(y / 38); }

// What the left column is that the right image shows at a column.
double left_column(double right, double y) {
  double x = right + 40;
  for (int i = 0; i < 60; ++i) x = right + disparity(x, y);
  return x;
}

struct Pair {
  GreyImage left{480, 300, 1}, right{480, 300, 1};
  std::vector<LevelPoint> guide;

  explicit Pair(double noise_grey) {
    Random random(9);
    const auto grey = [&](double value) {
      return std::uint8_t(std::clamp(std::lround(value + noise_grey * random.normal()), 1L, 255L));
    };
    for (int y = 0; y < 300; ++y)
      for (int x = 0; x < 480; ++x) {
        left.at(x, y) = grey(texture(x + 0.5, y + 0.5));
        right.at(x, y) = grey(texture(left_column(x + 0.5, y + 0.5), y + 0.5));
      }
    for (int y = 30; y < 300; y += 80)
      for (int x = 60; x < 480; x += 90) guide.push_back({{x + 0.5, y + 0.5}, disparity(x + 0.5, y + 0.5), 0, 1, 0.1});
  }
};

const auto kExact = [](const Eigen::Vector2d&) { return 0.1; };

// Errors of a pixel or less as root mean square, and the share of larger ones. Noise of 2 grey and a surface that bends
// within the windows leave 0.03 px.
struct Errors {
  double rms_px = 0, gross = 0;

  explicit Errors(const std::vector<LevelPoint>& points) {
    double squares = 0;
    for (const LevelPoint& point : points) {
      const double error = point.disparity_px - disparity(point.left_px.x(), point.left_px.y());
      gross += std::abs(error) > 1;
      if (std::abs(error) <= 1) squares += error * error;
    }
    gross /= double(points.size());
    rms_px = std::sqrt(squares / double(points.size()));
  }
};

TEST(LevelMatching, FindsTheSurfaceOfAPair) {
  const Pair pair(2);
  LevelOptions options;
  options.levels = 4;
  options.last_threshold = 200;
  options.grid_px = 6;
  const auto surface = match_by_levels(pair.left, pair.right, pair.guide, kExact, options, {});
  ASSERT_TRUE(surface) << surface.error().message;
  ASSERT_EQ(surface->levels.size(), 5u);
  EXPECT_GT(surface->points.size(), 2000u);
  const Errors errors(surface->points);
  EXPECT_LT(errors.gross, 0.01);
  EXPECT_LT(errors.rms_px, 0.05);
}

// At half the size first: as many points as from whole images, and as good.
TEST(LevelMatching, ByWayOfReducedImages) {
  const Pair pair(2);
  LevelOptions options;
  options.levels = 4;
  options.last_threshold = 100;
  options.grid_px = 6;
  const auto whole = match_by_levels(pair.left, pair.right, pair.guide, kExact, options, {});
  options.whole_mpx = 0.04;
  const auto reduced = match_by_levels(pair.left, pair.right, pair.guide, kExact, options, {});
  ASSERT_TRUE(whole && reduced);
  EXPECT_EQ(reduced->levels.front().shrink, 2);
  EXPECT_EQ(reduced->levels.back().shrink, 1);
  EXPECT_GT(double(reduced->points.size()), 0.99 * double(whole->points.size()));
  const Errors errors(reduced->points);
  EXPECT_EQ(errors.gross, 0);
  EXPECT_LT(errors.rms_px, 0.05);
}

TEST(LevelMatching, SameBitsForAnyNumberOfThreads) {
  const Pair pair(4);
  LevelOptions options;
  options.levels = 2;
  options.last_threshold = 2000;
  collinea::Run two;
  two.threads = 2;
  const auto one = match_by_levels(pair.left, pair.right, pair.guide, kExact, options, {});
  const auto both = match_by_levels(pair.left, pair.right, pair.guide, kExact, options, two);
  ASSERT_TRUE(one && both);
  ASSERT_EQ(one->points.size(), both->points.size());
  for (std::size_t i = 0; i < one->points.size(); ++i)
    EXPECT_EQ(one->points[i].disparity_px, both->points[i].disparity_px);
}

// A level without points does not take the place of its guide, and says so.
TEST(LevelMatching, ALevelOfTooFewPointsIsDropped) {
  const Pair pair(2);
  LevelOptions options;
  options.first_threshold = 1e6;
  options.last_threshold = 500;
  options.levels = 2;
  const auto surface = match_by_levels(pair.left, pair.right, pair.guide, kExact, options, {});
  ASSERT_TRUE(surface);
  ASSERT_EQ(surface->levels.size(), 2u);
  EXPECT_EQ(surface->levels[0].interest, 0u);
  EXPECT_TRUE(surface->levels[0].is_dropped);
  EXPECT_FALSE(surface->levels[1].is_dropped);
  EXPECT_GT(surface->points.size(), pair.guide.size());
}

TEST(LevelMatching, SpikesGoAndSlopesStay) {
  std::vector<LevelPoint> points;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 30; ++x) points.push_back({{10.0 * x, 10.0 * y}, 0.5 * x, 0, 1, 0.1});
  std::size_t wrong = 0;
  for (std::size_t i = 7; i < points.size(); i += 13, ++wrong) points[i].disparity_px += i % 2 ? 30 : -25;
  const auto kept = without_spikes(points);
  EXPECT_EQ(kept.size(), points.size() - wrong);
  for (const LevelPoint& point : kept) EXPECT_EQ(point.disparity_px, 0.05 * point.left_px.x());
  EXPECT_EQ(without_spikes({points.begin(), points.begin() + 5}).size(), 5u);  // too few to say
}

// Six points of a flat roof among those of the ground, 20 px apart: no median tells them from spikes.
TEST(LevelMatching, ARoofOfFewPointsStays) {
  std::vector<LevelPoint> points;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) {
      const bool is_roof = x >= 8 && x <= 9 && y >= 8 && y <= 10;
      points.push_back({{20.0 * x, 20.0 * y}, is_roof ? 55.0 : 40.0, 0, 1, 0.1});
    }
  EXPECT_EQ(without_spikes(points).size(), points.size());
  points[5 * 20 + 5].disparity_px = 55;  // one by itself
  EXPECT_EQ(without_spikes(points).size(), points.size() - 1);
}

// On a steep slope a point that lies off it goes, though by less than its neighbours lie apart.
TEST(LevelMatching, ASpikeOnASlopeGoes) {
  std::vector<LevelPoint> points;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) points.push_back({{6.0 * x, 6.0 * y}, 2.4 * x, 0, 1, 0.1, {0.4, 0}});
  points[10 * 20 + 10].disparity_px += 2.6;
  EXPECT_EQ(without_spikes(points).size(), points.size() - 1);
}

// Karfis W13: the filter by mean and standard deviation in a circle keeps a third of wrong points, since these make the
// standard deviation. Here they all go: a wrong point has some five wrong ones among its 16 neighbours, each of which
// bears it out with a chance of 2 (0.5 + 0.1 * 20 px) / 40 px = 0.12 where its sign is the same, 0.06 in all, and four
// would have to: 5 * 0.06^4, 1e-4 a point.
TEST(LevelMatching, AThirdOfClusteredErrorsGoesInKarfisW13) {
  Random random(13);
  std::vector<LevelPoint> points;
  std::vector<bool> wrong;
  double sum = 0, squares = 0, largest = 0;
  int count = 0;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 30; ++x) {
      const bool in_circle = std::hypot(x - 14.5, y - 14.5) < 6;
      wrong.push_back(in_circle && (x + y) % 3 == 0);
      const double error = wrong.back() ? random.uniform(20, 40) * (random.uniform() < 0.5 ? -1 : 1) : 0;
      points.push_back({{10.0 * x, 10.0 * y}, 40 + error + 0.2 * random.normal(), 0, 1, 0.1});
      if (!in_circle) continue;
      ++count, sum += points.back().disparity_px - 40, squares += std::pow(points.back().disparity_px - 40, 2);
      largest = std::max(largest, std::abs(error));
    }
  const double mean = sum / count, deviation = std::sqrt(squares / count - mean * mean);
  EXPECT_LT(largest + std::abs(mean), 3 * deviation);  // his limit: nothing goes
  const auto kept = without_spikes(points);
  // An error within half a pixel and a tenth of a distance of 10 to 30 px is none that neighbours could deny.
  for (const LevelPoint& point : kept) EXPECT_LT(std::abs(point.disparity_px - 40), 3.5);
  EXPECT_GE(kept.size(), std::size_t(std::count(wrong.begin(), wrong.end(), false)));  // every right one stays
}

LevelOptions of_one_threshold(int levels) {
  LevelOptions options;
  options.levels = levels;
  options.first_threshold = options.last_threshold = 500;
  return options;
}

// Karfis W13: the same interest points with a denser guide (his levels 4 and 5, 4414 points both) are no more points.
// The interval shrinks, and what was in it is in it still: the same points but for some at the border, below 1 %.
TEST(LevelMatching, TheSamePointsWithADenserGuideAreNotMoreInKarfisW13) {
  const Pair pair(2);
  const auto surface = match_by_levels(pair.left, pair.right, pair.guide, kExact, of_one_threshold(2), {});
  ASSERT_TRUE(surface) << surface.error().message;
  const LevelCount &first = surface->levels[0], &second = surface->levels[1];
  ASSERT_GT(first.matched, 20 * pair.guide.size());
  EXPECT_EQ(second.interest, first.interest);
  EXPECT_LT(second.median_interval_px, 0.5 * first.median_interval_px);  // guide: 90 px apart, then some 10
  EXPECT_NEAR(double(second.matched), double(first.matched), 0.01 * double(first.matched));
}

// Karfis W13: the guide are the points of the relative orientation (way 1), or interest points looked for along the
// whole epipolar line (way 2), some of which are wrong. A wrong guide asks for longer intervals; the homologous points
// lie within them, so that both ways end at one surface: the same share of points, as good.
TEST(LevelMatching, BothWaysOfTheGuideEndAtOneSurfaceInKarfisW13) {
  const Pair pair(2);
  const auto by_points = match_by_levels(pair.left, pair.right, pair.guide, kExact, of_one_threshold(2), {});
  const auto along_lines =
      match_rectified_by_levels(pair.left, pair.right, {0, 120}, of_one_threshold(2), {});  // 35 to 60 px are true
  std::vector<LevelPoint> wrong = pair.guide;
  for (std::size_t i = 2; i < wrong.size(); i += 5) wrong[i].disparity_px += i % 2 ? 25 : -25;
  const auto by_wrong = match_by_levels(pair.left, pair.right, wrong, kExact, of_one_threshold(2), {});
  ASSERT_TRUE(by_points && along_lines && by_wrong);
  EXPECT_GT(by_wrong->levels[0].median_interval_px, 1.2 * by_points->levels[0].median_interval_px);
  for (const LevelSurface* each : {&*by_points, &along_lines->surface, &*by_wrong}) {
    EXPECT_NEAR(double(each->points.size()), double(by_points->points.size()), 0.02 * double(by_points->points.size()));
    const Errors errors(each->points), expected(by_points->points);
    EXPECT_LT(errors.gross, 0.01);
    EXPECT_NEAR(errors.rms_px, expected.rms_px, 0.02 * expected.rms_px);  // most points are the same
  }
}

TEST(LevelMatching, RefusesWhatCannotGuide) {
  const Pair pair(0);
  EXPECT_FALSE(match_by_levels(pair.left, pair.right, {}, kExact, {}, {}));
  EXPECT_FALSE(match_by_levels(pair.left, GreyImage(480, 299, 1), pair.guide, kExact, {}, {}));
  LevelOptions rising;
  rising.first_threshold = 10;
  EXPECT_FALSE(match_by_levels(pair.left, pair.right, pair.guide, kExact, rising, {}));
}

}  // namespace
}  // namespace collinea
