// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/linear_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Scene {
  Rigid3 cam_from_world;
  std::vector<ProjectedPoint> points;

  Scene(std::uint64_t seed, int count, double sigma, bool is_plane) {
    Random random(seed);
    cam_from_world = {rotation_by(scene::random_vector(random, 0.5)), {0.4, -0.3, 12}};
    // The plane is none of the axes': it has a slope.
    for (int i = 0; i < count; ++i) {
      ProjectedPoint point;
      point.in_object = scene::random_vector(random, 3);
      if (is_plane) point.in_object.z() = 0.3 * point.in_object.x() - 0.1 * point.in_object.y() + 0.5;
      point.in_image = (cam_from_world * point.in_object).hnormalized() + scene::noise(random, sigma);
      point.sigma = sigma > 0 ? sigma : 1e-4;
      points.push_back(point);
    }
  }
};

TEST(LinearPose, ExactPointsGiveThePose) {
  for (const bool is_plane : {false, true})
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      const Scene scene(seed, (is_plane ? 4 : 6) + int(seed % 5), 0, is_plane);
      const auto found = linear_pose(scene.points);
      ASSERT_TRUE(found) << is_plane << seed;
      EXPECT_EQ(found->is_plane, is_plane);
      // Depths come from an eigenvector of squares: half of the digits where few points leave it weak.
      EXPECT_LT(angle_between(found->cam_from_world.rotation, scene.cam_from_world.rotation), 1e-5) << seed;
      EXPECT_LT((centre_of(found->cam_from_world) - centre_of(scene.cam_from_world)).norm(), 1e-4) << seed;
      double redundancy = 0;
      for (const Vector2d& r : found->redundancies) redundancy += r.sum();
      EXPECT_NEAR(redundancy, found->redundancy, 1e-4);
    }
}

// 400 seeds: the mean of chi-squared over its f degrees of freedom scatters by sqrt(2 / f / 400), f = 6 of the pose and
// 26 of sigma0 and at most that of the tests; the share below the 95 % bound by 0.011: four of each.
TEST(LinearPose, CovariancesMatchTheRealErrors) {
  for (const bool is_plane : {false, true}) {
    constexpr int kSeeds = 400;
    double sum = 0, squares = 0, tests = 0;
    int inside = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
      const Scene scene(static_cast<std::uint64_t>(seed), 16, 1e-5, is_plane);
      const auto found = linear_pose(scene.points);
      ASSERT_TRUE(found);
      // R' = R_true exp(r) of world_from_cam: r is the rotation about the axes of the world.
      const Eigen::AngleAxisd turn(found->cam_from_world.rotation.conjugate() * scene.cam_from_world.rotation);
      Eigen::Matrix<double, 6, 1> error;
      error << turn.angle() * turn.axis(), centre_of(found->cam_from_world) - centre_of(scene.cam_from_world);
      const Eigen::Matrix<double, 6, 1> unit = found->covariance.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::Matrix<double, 6, 6> scaled = unit.asDiagonal() * found->covariance * unit.asDiagonal();
      const Eigen::Matrix<double, 6, 1> e = unit.asDiagonal() * error;
      const double chi2 = e.dot(scaled.ldlt().solve(e));
      sum += chi2 / 6 / kSeeds;
      inside += chi2 < 12.592;
      squares += found->sigma0 * found->sigma0 / kSeeds;
      for (const Vector2d& w : found->w) tests += w.squaredNorm() / 32 / kSeeds;
    }
    EXPECT_NEAR(sum, 1, 4 * std::sqrt(2.0 / 6 / kSeeds)) << is_plane;
    EXPECT_NEAR(double(inside) / kSeeds, 0.95, 0.044) << is_plane;
    EXPECT_NEAR(squares, 1, 4 * std::sqrt(2.0 / 26 / kSeeds)) << is_plane;
    EXPECT_NEAR(tests, 1, 4 * std::sqrt(2.0 / 26 / kSeeds)) << is_plane;
  }
}

TEST(LinearPose, TooFewPointsAndPointsOnALineHaveNone) {
  EXPECT_FALSE(linear_pose(Scene(1, 5, 0, false).points));
  EXPECT_FALSE(linear_pose(Scene(1, 3, 0, true).points));
  Scene line(1, 8, 0, false);
  for (ProjectedPoint& point : line.points) {
    point.in_object = point.in_object.x() * Vector3d(1, 2, -0.5);
    point.in_image = (line.cam_from_world * point.in_object).hnormalized();
  }
  EXPECT_FALSE(linear_pose(line.points));
  Scene same(1, 8, 0, false);
  for (ProjectedPoint& point : same.points) point = same.points[0];
  EXPECT_FALSE(linear_pose(same.points));
}

// The mirrored image of points in space fits depths without error, but no rotation: there is no pose. That of a plane
// is what a camera on its other side sees, x mirrored: rotation S R N and centre N C, with S = diag(-1, 1, 1) and N the
// reflection in the plane.
TEST(LinearPose, AMirroredImageIsNoneInSpaceAndOneFromBehindAPlane) {
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    for (const bool is_plane : {false, true}) {
      Scene scene(seed, 12, 0, is_plane);
      for (ProjectedPoint& point : scene.points) point.in_image.x() = -point.in_image.x();
      const auto found = linear_pose(scene.points);
      ASSERT_EQ(found.has_value(), is_plane) << seed;
      if (!is_plane) continue;
      const Vector3d normal = Vector3d(-0.3, 0.1, 1).normalized(), on_plane(0, 0, 0.5);
      const Vector3d centre = centre_of(scene.cam_from_world);
      const Vector3d behind = centre - 2 * normal.dot(centre - on_plane) * normal;
      EXPECT_LT((centre_of(found->cam_from_world) - behind).norm(), 1e-4) << seed;  // digits as above
      EXPECT_LT(found->sigma0, 0.1);                                                // in units of 1e-4: the same digits
    }
}

}  // namespace
}  // namespace collinea
