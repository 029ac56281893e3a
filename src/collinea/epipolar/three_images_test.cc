// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/three_images.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

struct Triplet {
  Rigid3 second_from_first, third_from_second;  // the second base is 0.7 of the first
  std::vector<TriplePoint> points;
};

Triplet triplet(Random& random, double sigma) {
  Triplet out{scene::random_motion(random), scene::random_motion(random), {}};
  out.third_from_second.translation *= 0.7;
  const Rigid3 third = out.third_from_second * out.second_from_first;
  while (out.points.size() < 12) {
    const Eigen::Vector3d x = scene::random_point(random);
    if ((out.second_from_first * x).z() < 1 || (third * x).z() < 1) continue;
    out.points.push_back({x.hnormalized() + scene::noise(random, sigma),
                          scene::seen(out.second_from_first, x) + scene::noise(random, sigma),
                          scene::seen(third, x) + scene::noise(random, sigma)});
  }
  return out;
}

// Mussio D.3: sixteen combinations, two of them acceptable, mirror images of each other.
TEST(ThreeImages, TwoOfTheSixteenCombinationsJoinAndOneIsInFront) {
  for (int seed = 1; seed <= 30; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const Triplet truth = triplet(random, 0);
    Rigid3 second_pair = truth.third_from_second;
    second_pair.translation.normalize();
    const auto joined = join_three_images(truth.second_from_first, second_pair, truth.points);
    ASSERT_TRUE(joined);
    int acceptable = 0;
    for (const auto& one : joined->combinations) acceptable += one.is_joined;
    EXPECT_EQ(acceptable, 2);
    const auto& chosen = joined->combinations[static_cast<std::size_t>(joined->chosen)];
    EXPECT_EQ(chosen.in_front, 12);
    EXPECT_NEAR(chosen.base_ratio, 0.7, 1e-8);
    const Rigid3 third = truth.third_from_second * truth.second_from_first;
    EXPECT_LT((joined->third_from_first.translation - third.translation).norm(), 1e-7);
    EXPECT_LT(angle_between(joined->third_from_first.rotation, third.rotation), 1e-7);
  }
}

TEST(ThreeImages, AnyOfTheFourOrientationsOfAPairMayBeGiven) {
  Random random(5);
  const Triplet truth = triplet(random, 1e-4);
  Rigid3 mirrored = truth.second_from_first;
  mirrored.translation *= -1;
  Rigid3 second_pair = truth.third_from_second;
  second_pair.translation *= -3;
  const auto joined = join_three_images(mirrored, second_pair, truth.points);
  ASSERT_TRUE(joined);
  EXPECT_LT((joined->second_from_first.translation - truth.second_from_first.translation).norm(), 1e-9);
  EXPECT_NEAR(joined->combinations[static_cast<std::size_t>(joined->chosen)].base_ratio, 0.7, 0.01);
}

TEST(ThreeImages, WithoutCommonPointsThereIsNoRatioOfBases) {
  Random random(6);
  const Triplet truth = triplet(random, 0);
  EXPECT_FALSE(join_three_images(truth.second_from_first, truth.third_from_second, {}));
  EXPECT_FALSE(join_three_images(truth.second_from_first, truth.third_from_second, std::span(truth.points).first(1)));
}

}  // namespace
}  // namespace collinea
