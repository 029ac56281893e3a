// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/relative_start.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using namespace scene;

// The last `wrong` pairs are of something else, or (`size_px`) off by so much in some direction.
PointPairs pairs_with_wrong(const Rigid3& motion, int good, int wrong, Random& random, double size_px = 0) {
  PointPairs pairs = pairs_of(motion, good + wrong, 0.5, random, random_point);
  for (int i = good; i < good + wrong; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double angle = random.uniform(0, 6.283);
    pairs.x2[k] = size_px > 0 ? pairs.x2[k] + size_px / 1000 * std::cos(angle) : random.uniform(-0.5, 0.5);
    pairs.y2[k] = size_px > 0 ? pairs.y2[k] + size_px / 1000 * std::sin(angle) : random.uniform(-0.5, 0.5);
  }
  return pairs;
}

// Scenes of 20 in which rotation or base are far off: 0.5 px of 1000 px over 60 degrees and 55 good pairs tell the
// direction of the base to a few milliradians.
int count_far(RobustStart kind, int wrong, double size_px) {
  Random random(3);
  int far = 0;
  for (int scene = 0; scene < 20; ++scene) {
    const Rigid3 motion = random_motion(random);
    const auto found = relative_start(pairs_with_wrong(motion, 100 - wrong, wrong, random, size_px), kind, 1);
    EXPECT_TRUE(found);
    if (!found) continue;
    far += angle_between(found->second_from_first.rotation, motion.rotation) > 0.01 ||
           angle_between_vectors(found->second_from_first.translation, motion.translation) > 0.05;
    if (kind != RobustStart::kLeastMedian) continue;
    EXPECT_GT(found->in_front, 40);
    // Wrong pairs near the epipolar lines of others count as right.
    EXPECT_GT(found->scale_px, 0.3);
    EXPECT_LT(found->scale_px, size_px == 20 ? 2.5 : 1.5);
  }
  return far;
}

TEST(RelativeStart, FortyFivePercentWrongPairsDoNoHarmToTheLeastMedian) {
  for (const double size_px : {0.0, 20.0, 100.0}) EXPECT_EQ(count_far(RobustStart::kLeastMedian, 45, size_px), 0);
}

// The sum of absolute errors stands as many that are not far off, but no wrong pairs anywhere: theirs is larger than
// that of all others.
TEST(RelativeStart, TheLeastSumStandsErrorsThatAreNotLarge) {
  EXPECT_LE(count_far(RobustStart::kL1, 45, 20), 2);
  EXPECT_GT(count_far(RobustStart::kL1, 45, 0), 5);
}

TEST(RelativeStart, OfFewPairsAllSamplesAreLookedAt) {
  Random random(5);
  const Rigid3 motion = random_motion(random);
  const PointPairs pairs = pairs_with_wrong(motion, 12, 2, random);
  const auto found = relative_start(pairs, RobustStart::kLeastMedian, 1);
  ASSERT_TRUE(found);
  EXPECT_LT(angle_between(found->second_from_first.rotation, motion.rotation), 0.02);
  for (const int i : found->inliers) EXPECT_LT(i, 12);
}

TEST(RelativeStart, WithoutNoiseItIsExact) {
  Random random(6);
  const Rigid3 motion = random_motion(random);
  const PointPairs pairs = pairs_of(motion, 30, 0, random, random_point);
  for (const RobustStart kind : {RobustStart::kLeastMedian, RobustStart::kL1}) {
    const auto found = relative_start(pairs, kind, 1);
    ASSERT_TRUE(found);
    EXPECT_LT(angle_between(found->second_from_first.rotation, motion.rotation), 1e-5);
    EXPECT_EQ(found->in_front, 30);
  }
}

TEST(RelativeStart, TooFewPairsOrAllTheSameAreNoAnswer) {
  Random random(7);
  const Rigid3 motion = random_motion(random);
  EXPECT_FALSE(relative_start({}, RobustStart::kLeastMedian, 1));
  EXPECT_FALSE(relative_start(pairs_of(motion, 7, 0.5, random, random_point), RobustStart::kLeastMedian, 1));
  PointPairs same;
  same.focal_first_px = same.focal_second_px = 1000;
  for (int i = 0; i < 20; ++i) same.add({0.1, 0.2}, {0.1, 0.2});
  for (const RobustStart kind : {RobustStart::kLeastMedian, RobustStart::kL1})
    if (const auto found = relative_start(same, kind, 1)) EXPECT_TRUE(found->second_from_first.translation.allFinite());
}

}  // namespace
}  // namespace collinea
