// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/line_matching.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFocal_px = 1000, kBase = 1;

// A line through two points, brighter on the right of who goes from one to the other (y down); `sigma_px` across at
// both ends, independent.
EdgeLine line_through(const Vector2d& from, const Vector2d& to, double sigma_px = 0.01) {
  const Vector2d along = (to - from).normalized(), normal(along.y(), -along.x());
  EdgeLine line{.theta_rad = std::atan2(normal.y(), normal.x()), .r_px = normal.dot(from), .from = from, .to = to};
  Eigen::Matrix2d by;  // of the distances of both ends, by theta and r
  by << along.dot(from), -1, along.dot(to), -1;
  const Eigen::Matrix2d inverse = by.inverse();
  line.covariance = sigma_px * sigma_px * inverse * inverse.transpose();
  return line;
}

// An epipolar pair: x right, y down, z forward of the left camera, the right one a base to the right.
Vector2d seen(const Vector3d& point, double camera_x) {
  return {500 + kFocal_px * (point.x() - camera_x) / point.z(), 400 + kFocal_px * point.y() / point.z()};
}

struct PairOfLines {
  std::vector<MatchableLine> left, right;  // of the same number: the same edge

  void add(const Vector3d& from, const Vector3d& to, const SideGreys& greys) {
    left.push_back({line_through(seen(from, 0), seen(to, 0)), greys});
    right.push_back({line_through(seen(from, kBase), seen(to, kBase)), greys});
  }
};

// Segments of 0.4 to 1.2 m between 4 and 8 m, none within 15 degrees of the rows, each with grey values of its own.
PairOfLines scene(std::uint64_t seed, int count) {
  Random random(seed);
  PairOfLines lines;
  while (int(lines.left.size()) < count) {
    const double depth = random.uniform(4, 8);
    const Vector3d from(random.uniform(-0.4, 0.6) * depth, random.uniform(-0.35, 0.35) * depth, depth);
    const double angle = random.uniform(15, 165) * kDegree * (random.uniform() < 0.5 ? -1 : 1);
    const Vector3d to =
        from + random.uniform(0.4, 1.2) * Vector3d(std::cos(angle), std::sin(angle), random.uniform(-0.2, 0.2));
    const double darker = random.uniform(10, 120);
    lines.add(from, to, {darker, darker + random.uniform(20, 120)});
  }
  return lines;
}

std::size_t wrong(const std::vector<LineDecision>& decisions) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < decisions.size(); ++i) count += decisions[i].match && decisions[i].match->right != i;
  return count;
}
std::size_t matched(const std::vector<LineDecision>& decisions) {
  return std::size_t(std::ranges::count_if(decisions, [](const LineDecision& d) { return d.match.has_value(); }));
}

TEST(LineMatching, EveryEdgeOfAnExactSceneIsFound) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const PairOfLines lines = scene(seed, 20);
    const auto decisions = match_lines(lines.left, lines.right, 110, 270, {.grey_sigma = 5});
    EXPECT_EQ(matched(decisions), 20u) << seed;
    EXPECT_EQ(wrong(decisions), 0u) << seed;
  }
}

TEST(LineMatching, TheOrderOfTheLinesDoesNotMatter) {
  const PairOfLines lines = scene(3, 20);
  std::vector<MatchableLine> turned(lines.right.rbegin(), lines.right.rend());
  const auto decisions = match_lines(lines.left, turned, 110, 270, {.grey_sigma = 5});
  for (std::size_t i = 0; i < 20; ++i) {
    ASSERT_TRUE(decisions[i].match);
    EXPECT_EQ(decisions[i].match->right, 19 - i);
    EXPECT_EQ(decisions[i].match->left, i);
  }
}

TEST(LineMatching, DisparitiesAreThoseOfTheEnds) {
  PairOfLines lines;
  lines.add({0, -1, 5}, {0.2, 1, 6}, {40, 90});
  const auto decisions = match_lines(lines.left, lines.right, 100, 300, {});
  ASSERT_TRUE(decisions[0].match);
  EXPECT_EQ(decisions[0].outcome, LineOutcome::kOne);
  EXPECT_NEAR(decisions[0].match->first_disparity, kFocal_px * kBase / 5, 1e-9);
  EXPECT_NEAR(decisions[0].match->last_disparity, kFocal_px * kBase / 6, 1e-9);
  EXPECT_NEAR(decisions[0].match->overlap, 1, 1e-12);
}

// An edge parallel to the base lies along a row in both images and has no disparity.
TEST(LineMatching, AnEdgeParallelToTheBaseIsNotMatched) {
  PairOfLines lines;
  lines.add({-1, 0.5, 5}, {1, 0.5, 5}, {40, 90});
  lines.add({0, -1, 5}, {0.2, 1, 5}, {40, 90});
  const auto decisions = match_lines(lines.left, lines.right, 100, 300, {});
  EXPECT_EQ(decisions[0].outcome, LineOutcome::kAlongRows);
  EXPECT_FALSE(decisions[0].match);
  EXPECT_EQ(decisions[1].outcome, LineOutcome::kOne);
  EXPECT_FALSE(crossing(line_through({10, 50}, {90, 50}), 50));
}

TEST(LineMatching, WhatDoesNotAgreeIsNoCandidate) {
  PairOfLines lines;
  lines.add({0, -1, 5}, {0.2, 1, 5}, {40, 90});
  const auto none = [&](PairOfLines changed, double low = 100, double high = 300) {
    return line_candidates(changed.left, changed.right, low, high, {}).empty();
  };
  EXPECT_FALSE(none(lines));
  EXPECT_TRUE(none(lines, 201, 300));  // the disparity is 200
  EXPECT_TRUE(none(lines, 100, 199));
  PairOfLines contrast = lines;  // bright on the other side
  contrast.right[0].line = line_through(contrast.right[0].line.to, contrast.right[0].line.from);
  EXPECT_TRUE(none(contrast));
  // Rotated by 24 degrees through the direction of the rows: along a row, bright comes first in one image alone.
  const MatchableLine rising{line_through({200, 200}, {500, 264}), {40, 90}},
      falling{line_through({100, 264}, {400, 200}), {40, 90}};
  EXPECT_TRUE(line_candidates(std::span(&rising, 1), std::span(&falling, 1), -300, 500, {}).empty());
  EXPECT_FALSE(line_candidates(std::span(&rising, 1), std::span(&rising, 1), -300, 500, {}).empty());
  PairOfLines greys = lines;
  greys.right[0].greys = {140, 200};
  EXPECT_TRUE(none(greys));
  PairOfLines background = lines;  // one side alone changes
  background.right[0].greys.brighter = 250;
  EXPECT_FALSE(none(background));
  PairOfLines shorter = lines;  // other rows
  shorter.right[0].line = line_through({350, 700}, {350, 790});
  EXPECT_TRUE(none(shorter));
  PairOfLines turned = lines;
  turned.right[0].line = line_through({300, 200}, {700, 600});
  EXPECT_TRUE(none(turned));
}

// A fence: pickets alike, 20 px apart; the right image begins one picket later.
PairOfLines fence(Random& random) {
  PairOfLines lines;
  for (int k = 0; k < 12; ++k) {
    const double x = -0.6 + 0.1 * k;
    lines.add({x, -0.5, 5}, {x, 0.5, 5}, {60 + random.normal(), 140 + random.normal()});
  }
  return lines;
}

TEST(LineMatching, AFenceAloneStaysUndecided) {
  Random random(4);
  PairOfLines lines = fence(random);
  lines.left.pop_back();
  lines.right.erase(lines.right.begin());
  const auto decisions = match_lines(lines.left, lines.right, 120, 280, {});
  EXPECT_EQ(matched(decisions), 0u);
  for (const LineDecision& decision : decisions) {
    EXPECT_EQ(decision.outcome, LineOutcome::kUndecided);
    EXPECT_GT(decision.candidates, 1u);
  }
}

// Other edges of the same wall say which picket is which.
TEST(LineMatching, NeighboursTellPicketsApart) {
  Random random(5);
  PairOfLines lines = fence(random);
  for (int k = 0; k < 5; ++k) {
    const double x = -0.5 + 0.25 * k, darker = 10 + 40 * k;
    lines.add({x, -0.55, 5}, {x + 0.1, 0.45, 5}, {darker, darker + 60});
  }
  const auto decisions = match_lines(lines.left, lines.right, 120, 280, {.grey_sigma = 8});
  EXPECT_EQ(wrong(decisions), 0u);
  EXPECT_EQ(matched(decisions), 17u);
  EXPECT_EQ(
      std::ranges::count_if(decisions, [](const LineDecision& d) { return d.outcome == LineOutcome::kByNeighbours; }),
      12);
}

// Where a line with errors crosses a row: column less the true one over its sigma, mean square 1 with sqrt(2 / n).
TEST(LineMatching, SigmasOfCrossingsAreThoseOfTheErrors) {
  constexpr int kTrials = 2000;
  Random random(8);
  double sum = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double slope = random.uniform(-3, 3), row = random.uniform(180, 320);
    const Vector2d from(300, 200), to(300 + 100 * slope, 300), along = (to - from).normalized();
    const Vector2d normal(along.y(), -along.x());
    const double first = 0.05 * random.normal(), last = 0.05 * random.normal();
    const auto found = crossing(line_through(from + first * normal, to + last * normal, 0.05), row);
    ASSERT_TRUE(found);
    sum += std::pow((found->column - 300 - slope * (row - 200)) / found->sigma_px, 2);
  }
  EXPECT_NEAR(sum / kTrials, 1, 4 * std::sqrt(2.0 / kTrials));
}

// The disparity of a point of an edge, less the true one, over its sigma: mean square 1 with sqrt(2 / n).
TEST(LineMatching, SigmasOfEdgePointsAreThoseOfTheErrors) {
  constexpr int kTrials = 2000;
  constexpr double kSigma_px = 0.05;
  Random random(6);
  double sum = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double slope = random.uniform(-1.5, 1.5), disparity = random.uniform(20, 60);
    const Vector2d from(300, 200), to(300 + 100 * slope, 300), shift(-disparity, 0);
    const Vector2d along = (to - from).normalized(), normal(along.y(), -along.x());
    const auto off = [&] { return Vector2d(kSigma_px * random.normal() * normal); };
    const Vector2d from_right = from + shift + off(), to_right = to + shift + off();
    const EdgeLine right = line_through(from_right, to_right, kSigma_px);
    const Vector2d at = from + random.uniform(0.1, 0.9) * (to - from) + off();
    const EdgePoint point{at, normal, 20, kSigma_px};
    const LineCandidate match{.first_row = 200, .last_row = 300};
    const auto found = edge_point_matches(match, std::span(&point, 1), right);
    ASSERT_EQ(found.size(), 1u);
    sum += std::pow((found[0].left_px.x() - found[0].right_px.x() - disparity) / found[0].sigma_px, 2);
  }
  EXPECT_NEAR(sum / kTrials, 1, 4 * std::sqrt(2.0 / kTrials));
}

TEST(LineMatching, NothingToMatchIsNothing) {
  EXPECT_TRUE(match_lines({}, {}, 0, 100, {}).empty());
  PairOfLines lines;
  lines.add({0, -1, 5}, {0.2, 1, 5}, {40, 90});
  EXPECT_EQ(match_lines(lines.left, {}, 0, 300, {})[0].outcome, LineOutcome::kNoCandidate);
}

}  // namespace
}  // namespace collinea
