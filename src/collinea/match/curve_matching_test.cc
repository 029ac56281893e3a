// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/curve_matching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collinea/feature/edges.h"
#include "collinea/feature/test_shapes.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kNoise_grey = 4;

// Discs on a plane that leans: what is at x, y of the left image is disparity(y) farther left in the right one.
struct Disc {
  Vector2d at;
  double radius_px, white, disparity, lean;
  [[nodiscard]] double disparity_at(double row) const { return disparity + lean * (row - at.y()); }
};
using Scene = std::vector<Disc>;
const Scene kScene = {{{70, 60}, 24, 0.5, 30, 0.03}, {{150, 70}, 31, 0.9, 22, -0.05}, {{105, 140}, 18, 0.7, 36, 0}};

FloatImage rendered(const Scene& scene, bool is_right) {
  return render_shape(220, 190, [&](const Vector2d& p) {
    double sum = 0;
    for (const Disc& d : scene)
      sum += d.white * disc(d.at, d.radius_px, 0.8)(is_right ? Vector2d(p.x() + d.disparity_at(p.y()), p.y()) : p);
    return sum;
  });
}
std::vector<EdgeArc> arcs_in(const FloatImage& image) {
  return edge_arcs(detect_edges(image, {.noise_grey = kNoise_grey}), image, 20, 8, {});
}

// Both images of the scene, rendered once, with noise of their own each time.
struct NoisyPair {
  FloatImage left = rendered(kScene, false), right = rendered(kScene, true);
  std::vector<EdgeArc> left_arcs = {}, right_arcs = {};

  void draw(std::uint64_t seed) {
    left_arcs = arcs_in(with_noise(left, kNoise_grey, 2 * seed));
    right_arcs = arcs_in(with_noise(right, kNoise_grey, 2 * seed + 1));
  }
};

const Disc* disc_of(const Scene& scene, const Vector2d& left_px) {
  for (const Disc& d : scene)
    if (std::abs((left_px - d.at).norm() - d.radius_px) < 2) return &d;
  return nullptr;
}

TEST(CurveMatching, AClosedEdgeIsCutWhereItRunsAlongTheRows) {
  const FloatImage image = rendered({kScene[0]}, false);
  const auto arcs = arcs_in(image);
  ASSERT_EQ(arcs.size(), 2u);
  EXPECT_LT(arcs[0].points[0].normal.x() * arcs[1].points[0].normal.x(), 0);
  for (const EdgeArc& arc : arcs) {
    for (std::size_t i = 1; i < arc.points.size(); ++i) EXPECT_GT(arc.points[i].at.y(), arc.points[i - 1].at.y());
    // 20 degrees of each end are left: rows of 2 r cos 20.
    EXPECT_NEAR(arc.last_row() - arc.first_row(), 2 * 24 * std::cos(20 * std::numbers::pi / 180), 2.5);
    EXPECT_NEAR(arc.greys.brighter - arc.greys.darker, 120 * 0.5, 3);
    EXPECT_FALSE(crossing(arc, arc.first_row() - 0.01));
    EXPECT_FALSE(crossing(arc, arc.last_row() + 0.01));
    // Against the circle: chords are off by 1 / (8 r), smoothing by some 1.5 / (2 r).
    for (double row = 45; row < 75; row += 0.7)
      EXPECT_NEAR(std::abs(crossing(arc, row)->column - 70), std::sqrt(24 * 24 - (row - 60) * (row - 60)), 0.06);
  }
  const EdgeMap map = detect_edges(image, {.noise_grey = kNoise_grey});
  EXPECT_TRUE(edge_arcs(map, image, 20, 8, [](const Vector2d&) { return true; }).empty());
  EXPECT_TRUE(edge_arcs(map, image, 20, 1000, {}).empty());
}

TEST(CurveMatching, SidesOfDiscsAreMatchedWithTheDisparityOfEveryRow) {
  NoisyPair pair;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    pair.draw(seed);
    const auto &left = pair.left_arcs, &right = pair.right_arcs;
    const ArcMatches found = match_arcs(left, right, 5, 60, {});
    ASSERT_EQ(found.matches.size(), 6u) << seed;
    for (const ArcMatch& match : found.matches) {
      const auto points = arc_point_matches(match, left[match.left], right[match.right]);
      EXPECT_GT(points.size(), 20u);
      for (const EdgePointMatch& p : points) {
        const Disc* d = disc_of(kScene, p.left_px);
        ASSERT_TRUE(d);
        EXPECT_EQ(p.left_px.y(), p.right_px.y());
        EXPECT_NEAR(p.left_px.x() - p.right_px.x(), d->disparity_at(p.left_px.y()), 6 * p.sigma_px + 0.02);
      }
    }
  }
}

// (error / sigma)^2 of a disparity is chi-squared with one degree of freedom; points 6 px apart share hardly a pixel.
// The mean of n is 1 with a standard deviation of sqrt(2 / n). Smoothing moves both images of an edge alike, chords of
// 1 px are off by 0.005 px, a tenth of the sigma.
TEST(CurveMatching, SigmasOfDisparitiesAreThoseOfTheErrors) {
  double sum = 0;
  int count = 0;
  NoisyPair pair;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    pair.draw(seed);
    const auto &left = pair.left_arcs, &right = pair.right_arcs;
    for (const ArcMatch& match : match_arcs(left, right, 5, 60, {}).matches) {
      const auto points = arc_point_matches(match, left[match.left], right[match.right]);
      double last_row = -100;
      for (std::size_t i = 3; i + 3 < points.size(); ++i) {
        const EdgePointMatch& p = points[i];
        const Disc* d = disc_of(kScene, p.left_px);
        if (!d || p.left_px.y() < last_row + 6) continue;
        last_row = p.left_px.y();
        sum += std::pow((p.left_px.x() - p.right_px.x() - d->disparity_at(p.left_px.y())) / p.sigma_px, 2);
        ++count;
      }
    }
  }
  ASSERT_GT(count, 800);
  EXPECT_NEAR(sum / count, 1, 4 * std::sqrt(2.0 / count));
}

// Exact arcs by formula: of circles of the left image, cut where asked.
EdgeArc arc_by_formula(const Disc& d, bool is_right, double side, double first_row, double last_row) {
  EdgeArc arc{{}, {50, 50 + 120 * d.white}, 1};
  for (double row = first_row; row <= last_row; row += 1) {
    const double half = std::sqrt(d.radius_px * d.radius_px - (row - d.at.y()) * (row - d.at.y()));
    const Vector2d on(d.at.x() + side * half, row);
    arc.points.push_back({.at = on - Vector2d(is_right ? d.disparity_at(row) : 0, 0),
                          .normal = (d.at - on).normalized(),
                          .sigma_px = 0.05});
  }
  return arc;
}

TEST(CurveMatching, ABrokenEdgeMatchesWithBothOfItsPieces) {
  const Disc& d = kScene[1];
  const std::vector<EdgeArc> left = {arc_by_formula(d, false, 1, 45, 95)};
  const std::vector<EdgeArc> right = {arc_by_formula(d, true, 1, 45, 66), arc_by_formula(d, true, 1, 70, 95)};
  const ArcMatches found = match_arcs(left, right, 0, 60, {});
  ASSERT_EQ(found.matches.size(), 2u);
  EXPECT_EQ(found.matches[0].outcome, LineOutcome::kOne);
  EXPECT_EQ(found.matches[0].right, 0u);
  EXPECT_EQ(found.matches[1].right, 1u);
  EXPECT_NEAR(found.matches[0].last_row, 66, 1e-9);
  const ArcMatches back = match_arcs(right, left, -60, 0, {});
  EXPECT_EQ(back.matches.size(), 2u);
}

// Two discs that are alike, a third that is not: alone the two stay undecided, with a decided one on the same plane
// each is found.
TEST(CurveMatching, NeighboursTellLikeEdgesApart) {
  const Disc a{{60, 60}, 20, 0.5, 20, 0}, b{{78, 60}, 20, 0.5, 20, 0}, other{{70, 110}, 20, 0.9, 20, 0};
  const auto arcs = [](std::initializer_list<Disc> discs, bool is_right) {
    std::vector<EdgeArc> out;
    for (const Disc& d : discs) out.push_back(arc_by_formula(d, is_right, 1, d.at.y() - 15, d.at.y() + 15));
    return out;
  };
  const ArcMatches alone = match_arcs(arcs({a, b}, false), arcs({a, b}, true), 0, 60, {});
  EXPECT_TRUE(alone.matches.empty());
  EXPECT_GT(alone.undecided, 0u);
  const ArcMatches together = match_arcs(arcs({a, b, other}, false), arcs({a, b, other}, true), 0, 60, {});
  ASSERT_EQ(together.matches.size(), 3u);
  for (const ArcMatch& match : together.matches) EXPECT_EQ(match.left, match.right);
  EXPECT_EQ(together.matches[0].outcome, LineOutcome::kByNeighbours);
}

// Of two that are exactly alike neither is better, however little is asked for: none is taken by its place in the list.
TEST(CurveMatching, OfTwoThatAreAsSimilarNoneIsDecisive) {
  const Disc near{{60, 60}, 20, 0.5, 20, 0}, far{{60, 60}, 20, 0.5, 38, 0};
  const auto arc = [](const Disc& d, bool is_right) { return arc_by_formula(d, is_right, 1, 45, 75); };
  const std::vector<EdgeArc> left = {arc(near, false)}, right = {arc(near, true), arc(far, true)};
  const ArcMatches found = match_arcs(left, right, 0, 60, {.decisive_ratio = 1});
  EXPECT_EQ(found.candidates, 2u);
  EXPECT_EQ(found.undecided, 2u);
  EXPECT_TRUE(found.matches.empty());
  EXPECT_TRUE(match_arcs(right, left, -60, 0, {.decisive_ratio = 1}).matches.empty());  // of the other side
  // Another grey value on one side is enough.
  std::vector<EdgeArc> darker = right;
  darker[0].greys.brighter += 5;
  const ArcMatches better = match_arcs(left, darker, 0, 60, {.decisive_ratio = 1});
  ASSERT_EQ(better.matches.size(), 1u);
  EXPECT_EQ(better.matches[0].right, 1u);
  EXPECT_EQ(better.matches[0].outcome, LineOutcome::kDecisive);
}

TEST(CurveMatching, WhatDoesNotAgreeIsNoCandidate) {
  const Disc& d = kScene[0];
  const std::vector<EdgeArc> left = {arc_by_formula(d, false, 1, 45, 75)};
  const auto none = [&](const EdgeArc& right, double low, double high) {
    return match_arcs(left, std::vector{right}, low, high, {}).candidates == 0;
  };
  const EdgeArc same = arc_by_formula(d, true, 1, 45, 75);
  EXPECT_FALSE(none(same, 0, 60));
  EXPECT_TRUE(none(same, 40, 60));                                // the disparity
  EXPECT_TRUE(none(arc_by_formula(d, true, -1, 45, 75), 0, 90));  // the brighter side
  EXPECT_TRUE(none(arc_by_formula(d, true, 1, 77, 82), 0, 60));   // no row in common
  EdgeArc darker = same;
  darker.greys = {150, 250};
  EXPECT_TRUE(none(darker, 0, 60));
  EXPECT_TRUE(match_arcs({}, {}, 0, 60, {}).matches.empty());
}

}  // namespace
}  // namespace collinea
