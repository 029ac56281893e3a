// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/planar_resection.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

std::vector<PlanarDirection> directions_from(const Vector2d& station, double zero, int count, double sigma,
                                             Random& random) {
  std::vector<PlanarDirection> out;
  for (int i = 0; i < count; ++i) {
    const Vector2d to(1e5 + 500 * random.normal(), 2e5 + 500 * random.normal());
    const Vector2d d = to - station;
    out.push_back({to, std::atan2(d.x(), d.y()) - zero + sigma * random.normal(), sigma > 0 ? sigma : 1e-4});
  }
  return out;
}

TEST(PlanarResection, ExactDirectionsGiveTheStation) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(seed);
    const Vector2d station(1e5 + 300 * random.normal(), 2e5 + 300 * random.normal());
    const double zero = random.uniform(0, 6.28);
    const auto found = planar_resection(directions_from(station, zero, 3 + int(seed % 3), 0, random));
    ASSERT_TRUE(found);
    EXPECT_LT((found->station - station).norm(), 1e-4) << seed << " " << found->danger_off;
    EXPECT_NEAR(std::remainder(found->orientation_rad - zero, 2 * M_PI), 0, 1e-6);
  }
}

TEST(PlanarResection, CovarianceMatchesTheRealErrors) {
  constexpr int kSeeds = 500;
  double sum = 0, squares = 0, tests = 0;
  int inside = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const Vector2d station(1e5 + 100 * random.normal(), 2e5 + 100 * random.normal());
    const auto found = planar_resection(directions_from(station, 1, 6, 2e-5, random));
    ASSERT_TRUE(found);
    Eigen::Vector3d error;
    error << found->station - station, std::remainder(found->orientation_rad - 1, 2 * M_PI);
    const double chi2 = error.dot(found->covariance.ldlt().solve(error));
    sum += chi2 / 3;
    inside += chi2 < 7.815;
    squares += found->sigma0 * found->sigma0;
    for (const double w : found->w) tests += w * w / 6;
  }
  EXPECT_NEAR(sum / kSeeds, 1, 0.1);
  EXPECT_NEAR(squares / kSeeds, 1, 0.1);
  EXPECT_NEAR(tests / kSeeds, 1, 0.1);
  EXPECT_NEAR(double(inside) / kSeeds, 0.95, 0.02);
}

// Mussio 3.4.1: four points on a circle leave the station open; the nearer to it, the larger the standard deviation.
TEST(PlanarResection, OnTheDangerCircleThereIsNone) {
  double before = 1e99;
  for (const double off : {0.0, 1.0, 10.0, 100.0}) {
    const Vector2d station((500 + off) * std::cos(5.0), (500 + off) * std::sin(5.0));
    std::vector<PlanarDirection> directions;
    for (const double angle : {0.5, 1.4, 2.6}) {
      const Vector2d to(500 * std::cos(angle), 500 * std::sin(angle)), d = to - station;
      directions.push_back({to, std::atan2(d.x(), d.y()), 2e-5});
    }
    const auto found = planar_resection(directions);
    if (off == 0) {
      EXPECT_TRUE(!found || found->covariance.trace() > 1e6);
      continue;
    }
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->danger_radius, 500, 1e-6);
    EXPECT_NEAR(found->danger_off, off, 1e-3);
    EXPECT_LT(found->covariance(0, 0), before);
    before = found->covariance(0, 0);
  }
}

// On the circle the arc between two points is found on which the station lies; off it there is none, nor where the
// points are on no circle.
TEST(PlanarResection, OnTheDangerCircleAnArcIsOpen) {
  const auto seen_from = [](const Vector2d& station, double fourth) {
    std::vector<PlanarDirection> directions;
    for (const double angle : {0.5, 1.4, 2.6, 3.3}) {
      const double radius = angle > 3 ? fourth : 500;
      const Vector2d to(200 + radius * std::cos(angle), 100 + radius * std::sin(angle)), d = to - station;
      directions.push_back({to, std::atan2(d.x(), d.y()) - 0.7, 1e-8});
    }
    return directions;
  };
  for (const double at : {5.0, 1.0, 3.0}) {
    const auto on = [&](double radius) -> Vector2d {
      return {200 + radius * std::cos(at), 100 + radius * std::sin(at)};
    };
    const auto arc = open_arc(seen_from(on(500), 500));
    ASSERT_TRUE(arc) << at;
    EXPECT_LT((arc->circle.centre - Vector2d(200, 100)).norm(), 1e-6);
    EXPECT_NEAR(arc->circle.radius, 500, 1e-6);
    const double turns = std::floor((at - arc->from_rad) / (2 * M_PI)) * 2 * M_PI;
    EXPECT_LT(at - turns, arc->to_rad);
    EXPECT_LT(arc->misfit_rad, 1e-9);
    EXPECT_FALSE(open_arc(seen_from(on(510), 500))) << at;
    EXPECT_FALSE(open_arc(seen_from(on(500), 450))) << at;
  }
  EXPECT_FALSE(danger_circle(std::vector<Vector2d>{{0, 0}, {10, 10}, {30, 30}}));
  EXPECT_FALSE(danger_circle(std::vector<Vector2d>{{0, 0}, {10, 10}}));
}

// Of nine directions three may be wrong (9 - 4 - 2). Right ones are rejected at 2.5 standard deviations, one in 80, and
// more because the scale is that of few: less than one of the six in the mean.
TEST(PlanarResection, TheLeastMedianFindsWrongDirections) {
  int right_rejected = 0;
  constexpr int kSeeds = 50;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Random random(seed);
    auto directions = directions_from({1e5 + 50 * random.normal(), 2e5}, 1, 9, 2e-5, random);
    for (const std::size_t i : {1, 4, 6}) directions[i].direction_rad += 1e-3 * double(i + 1);
    const auto wrong = contradicting_directions(directions, 1);
    ASSERT_TRUE(wrong) << seed;
    for (const std::size_t i : {1, 4, 6}) EXPECT_TRUE(std::count(wrong->begin(), wrong->end(), i)) << seed << " " << i;
    right_rejected += static_cast<int>(wrong->size()) - 3;
  }
  EXPECT_LT(right_rejected, kSeeds);
  Random random(7);
  const auto none = contradicting_directions(directions_from({1e5, 2e5}, 1, 6, 0, random), 1);
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->empty());
  EXPECT_FALSE(contradicting_directions(directions_from({1e5, 2e5}, 1, 4, 0, random), 1));
  EXPECT_FALSE(contradicting_directions(std::vector<PlanarDirection>(6, {{1, 2}, 0.3, 1e-4}), 1));
}

TEST(PlanarResection, TooLittleIsRefused) {
  Random random(1);
  EXPECT_FALSE(planar_resection(directions_from({0, 0}, 0, 2, 0, random)));
  EXPECT_FALSE(planar_resection({}));
  EXPECT_FALSE(planar_resection(std::vector<PlanarDirection>(3, {{1, 2}, 0.3, 1e-4})));
}

}  // namespace
}  // namespace collinea
