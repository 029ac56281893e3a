// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/robust_projection.h"

#include <gtest/gtest.h>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

// `noise` of the image coordinates; their stated sigma is 0.5.
std::vector<ProjectedPoint> points_of(std::uint64_t seed, int count, double noise, bool is_plane) {
  Random random(seed);
  const Rigid3 pose{rotation_by(scene::random_vector(random, 0.5)), {0.4, -0.3, 12}};
  std::vector<ProjectedPoint> points;
  for (int i = 0; i < count; ++i) {
    ProjectedPoint point;
    point.in_object = scene::random_vector(random, 3);
    if (is_plane) point.in_object.z() = 0;
    const Vector3d in_camera = pose * point.in_object;
    point.in_image = 3000 * in_camera.hnormalized() + scene::noise(random, noise);
    point.sigma = 0.5;
    points.push_back(point);
  }
  return points;
}

// All wrong points are found, up to as many as the median stands; their errors are of any size. A right point is beyond
// 3.04 standard deviations in one of 100; its own fit and the scale of few points make it some more: of 20 points with
// 7 wrong less than one of 13 in the mean.
TEST(RobustProjection, FindsAsManyWrongPointsAsTheMedianStands) {
  for (const bool is_plane : {false, true}) {
    int right_rejected = 0;
    constexpr int kSeeds = 20, kCount = 20, kWrong = 7;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      auto points = points_of(seed, kCount, 0.5, is_plane);
      Random random(seed + 1000);
      for (std::size_t i = 0; i < kWrong; ++i)
        points[2 * i].in_image += Eigen::Vector2d(i % 2 ? 30 : -300, 40 * random.uniform(1, 10));
      const auto found = robust_projection(points, is_plane, 1);
      ASSERT_TRUE(found) << seed;
      for (std::size_t i = 0; i < kWrong; ++i)
        EXPECT_TRUE(std::count(found->contradicting.begin(), found->contradicting.end(), 2 * i)) << seed << " " << i;
      right_rejected += static_cast<int>(found->contradicting.size()) - kWrong;
      EXPECT_GT(found->scale, 0.15);
      EXPECT_LT(found->scale, 1.5);  // sigma is 0.5; few redundant points scatter by a factor of three
    }
    EXPECT_LT(right_rejected, kSeeds) << is_plane;
  }
}

TEST(RobustProjection, ExactPointsHaveNothingWrong) {
  for (const bool is_plane : {false, true}) {
    const auto found = robust_projection(points_of(3, 12, 0, is_plane), is_plane, 1);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->contradicting.empty());
  }
}

TEST(RobustProjection, TooFewOrFlatPointsHaveNoAnswer) {
  EXPECT_FALSE(robust_projection(points_of(3, 7, 0.5, false), false, 1));
  EXPECT_FALSE(robust_projection(points_of(3, 5, 0.5, true), true, 1));
  EXPECT_FALSE(robust_projection(points_of(3, 12, 0, true), false, 1));
}

}  // namespace
}  // namespace collinea
