// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/relaxation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// Points over a surface; each has its true position among `wrong` others that are as similar, or more.
struct CandidateScene {
  std::vector<PointCandidates> points;
  std::vector<std::size_t> truth;  ///< the candidate that is right
};
CandidateScene candidate_scene(int wrong, double share_without_truth, std::uint64_t seed) {
  Random random(seed);
  CandidateScene scene;
  for (int i = 0; i < 300; ++i) {
    PointCandidates point;
    point.point_px = {random.uniform(0, 1000), random.uniform(0, 1000)};
    point.expected_px = point.point_px;
    const Vector2d parallax(20 * std::sin(point.point_px.x() / 200) + 5 * std::cos(point.point_px.y() / 150), 0);
    const bool has_truth = random.uniform() >= share_without_truth;
    const auto truth = std::size_t(random.below(std::uint32_t(wrong + 1)));
    for (std::size_t k = 0; k <= std::size_t(wrong); ++k) {
      const bool is_truth = has_truth && k == truth;
      const Vector2d at = point.point_px + parallax +
                          (is_truth ? Vector2d(0.2 * random.normal(), 0.2 * random.normal())
                                    : Vector2d(random.uniform(-60, 60), random.uniform(-60, 60)));
      point.candidates.push_back({at, random.uniform(0.8, 0.95)});
    }
    scene.points.push_back(point);
    scene.truth.push_back(has_truth ? truth : 1000);
  }
  return scene;
}

TEST(Relaxation, NeighboursTellWhichOfManyIsRight) {
  const CandidateScene scene = candidate_scene(3, 0.1, 1);
  RelaxationOptions options;
  options.parallax_gradient = 0.1;  // the slope of the surface
  const auto matches = relax(scene.points, options);
  int right = 0, wrong = 0, with_truth = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    with_truth += scene.truth[i] < 1000;
    if (!matches[i].candidate) continue;
    (*matches[i].candidate == scene.truth[i] ? right : wrong) += 1;
    EXPECT_EQ(matches[i].outcome, RelaxedOutcome::kChosen);
  }
  EXPECT_GT(right, 0.93 * with_truth);
  EXPECT_LT(wrong, 0.03 * right);
}

TEST(Relaxation, WithoutRoundsSimilarityAloneDecidesNothingOfMany) {
  const CandidateScene scene = candidate_scene(3, 0, 2);
  RelaxationOptions none;
  none.iterations = 0;
  for (const RelaxedMatch& match : relax(scene.points, none)) EXPECT_EQ(match.outcome, RelaxedOutcome::kUndecided);
}

TEST(Relaxation, NoneOneAndManyAreToldApart) {
  std::vector<PointCandidates> points;
  for (int i = 0; i < 20; ++i) {
    const Vector2d at(10.0 * i, 0);
    points.push_back({at, at, {{at + Vector2d(5, 0), 0.9}}});
  }
  points[3].candidates.clear();
  points[5].candidates.push_back({points[5].point_px + Vector2d(40, 30), 0.95});
  points[7].candidates.front().position_px += Vector2d(30, -20);  // its only candidate is wrong
  points[9].candidates.front().position_px = points[10].candidates.front().position_px;
  points[9].candidates.front().similarity = 0.7;
  const auto matches = relax(points, {});
  EXPECT_EQ(matches[3].outcome, RelaxedOutcome::kNoCandidate);
  EXPECT_EQ(matches[4].outcome, RelaxedOutcome::kOne);
  EXPECT_EQ(matches[5].outcome, RelaxedOutcome::kChosen);
  EXPECT_EQ(matches[5].candidate, 0u);
  EXPECT_EQ(matches[7].outcome, RelaxedOutcome::kUndecided);
  EXPECT_FALSE(matches[9].candidate);
  EXPECT_EQ(matches[10].outcome, RelaxedOutcome::kOne);
}

TEST(Relaxation, FewPointsGiveAnAnswer) {
  EXPECT_TRUE(relax({}, {}).empty());
  const auto alone = relax({{{0, 0}, {0, 0}, {{{1, 0}, 0.9}}}}, {});
  ASSERT_EQ(alone.size(), 1u);
  EXPECT_EQ(alone[0].outcome, RelaxedOutcome::kUndecided);  // nobody bears it out
}

}  // namespace
}  // namespace collinea
