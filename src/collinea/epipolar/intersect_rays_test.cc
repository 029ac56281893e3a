// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/intersect_rays.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using namespace scene;

struct Rays {
  std::vector<Rigid3> cams;
  std::vector<Eigen::Vector2d> xy;
  std::vector<double> focal_px;
};

// Cameras on a ring of radius 1 looking roughly along z at a point some 5 away.
Rays rays_to(const Eigen::Vector3d& point, int count, double sigma, Random& random) {
  Rays rays;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    const Eigen::Quaterniond rotation = rotation_by(random_vector(random, 0.1));
    rays.cams.push_back({rotation, -(rotation * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0))});
    rays.xy.push_back(seen(rays.cams.back(), point) + noise(random, sigma));
    rays.focal_px.push_back(1000);
  }
  return rays;
}

TEST(IntersectRays, FindsTheExactPoint) {
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    const Eigen::Vector3d truth = random_point(random);
    const Rays rays = rays_to(truth, 2 + k % 5, 0, random);
    const auto point = intersect_rays(rays.cams, rays.xy);
    ASSERT_TRUE(point);
    EXPECT_LT((*point - truth).norm(), 1e-9);
    const auto middle = intersect_midpoint(rays.cams[0], rays.cams[1], rays.xy[0], rays.xy[1]);
    ASSERT_TRUE(middle);
    EXPECT_LT((*middle - truth).norm(), 1e-9);
  }
}

// e' N e / sigma^2 with the normal matrix N of the image coordinates is chi-squared with 3 degrees of freedom; over n
// points its mean is 3 with standard deviation sqrt(6 / n). Fails for the linear answer with the rays' unequal
// distances.
TEST(IntersectRays, ErrorsAreThoseOfLeastSquares) {
  Random random(2);
  constexpr int kTimes = 2000;
  constexpr double kSigma = 1e-3;
  double sum = 0;
  for (int k = 0; k < kTimes; ++k) {
    const Eigen::Vector3d truth = random_point(random);
    const Rays rays = rays_to(truth, 4, kSigma, random);
    const auto point = intersect_rays(rays.cams, rays.xy);
    ASSERT_TRUE(point);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    for (const Rigid3& cam : rays.cams) {
      Eigen::Matrix<double, 2, 3> j;
      for (int c = 0; c < 3; ++c) {
        const Eigen::Vector3d h = 1e-6 * Eigen::Vector3d::Unit(c);
        j.col(c) = (seen(cam, truth + h) - seen(cam, truth - h)) / 2e-6;
      }
      normal += j.transpose() * j;
    }
    const Eigen::Vector3d e = *point - truth;
    sum += e.dot(normal * e) / (kSigma * kSigma);
  }
  EXPECT_NEAR(sum / kTimes, 3, 4 * std::sqrt(6.0 / kTimes));
}

TEST(IntersectRays, ParallelRaysAndPointsBehindHaveNoAnswer) {
  Random random(3);
  const Rays far = rays_to({0, 0, 1e5}, 3, 0, random);
  EXPECT_FALSE(intersect_rays(far.cams, far.xy));
  EXPECT_FALSE(intersect_midpoint(far.cams[0], far.cams[1], far.xy[0], far.xy[1]));
  const Rigid3 left, right{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  const std::vector<Rigid3> cams = {left, right};
  const std::vector<Eigen::Vector2d> parallel = {{0.1, 0}, {0.1, 0}}, behind = {{-0.1, 0}, {0.1, 0}};
  EXPECT_FALSE(intersect_rays(cams, parallel, 0));
  EXPECT_FALSE(intersect_rays(cams, behind));
  EXPECT_FALSE(intersect_midpoint(left, right, parallel[0], parallel[1], 0));
  EXPECT_FALSE(intersect_midpoint(left, right, behind[0], behind[1]));
  EXPECT_FALSE(intersect_rays(std::span(cams).first(1), std::span(parallel).first(1)));
  EXPECT_FALSE(intersect_rays({}, {}));
}

TEST(MaxRayAngle, IsTheWidest) {
  const std::vector<Rigid3> cams = {{Eigen::Quaterniond::Identity(), {0, 0, 0}},
                                    {Eigen::Quaterniond::Identity(), {-1, 0, 0}},
                                    {Eigen::Quaterniond::Identity(), {1, 0, 0}}};
  EXPECT_NEAR(max_ray_angle_rad(cams, {0, 0, 1}), M_PI / 2, 1e-12);
  EXPECT_EQ(max_ray_angle_rad(std::span(cams).first(1), {0, 0, 1}), 0);
}

TEST(ReprojectionError, IsInPixelsAndInfiniteBehind) {
  EXPECT_NEAR(reprojection_error_px({}, {0.1, 0.2}, 1000, {0.103, 0.204, 1}), 5, 1e-9);
  EXPECT_TRUE(std::isinf(reprojection_error_px({}, {0.1, 0.2}, 1000, {0.1, 0.2, -1})));
}

TEST(RobustIntersect, LeavesOutTheWrongRays) {
  Random random(4);
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector3d truth = random_point(random);
    const int count = 5 + k % 12;
    Rays rays = rays_to(truth, count, 3e-4, random);
    const int wrong = count / 3;
    for (int i = 0; i < wrong; ++i)
      rays.xy[static_cast<std::size_t>((3 * i + k) % count)] +=
          Eigen::Vector2d(random.uniform(0.03, 0.2), random.uniform(0.03, 0.2));
    const auto found = robust_intersect(rays.cams, rays.xy, rays.focal_px, 3);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->inliers, count - wrong);
    for (int i = 0; i < wrong; ++i) EXPECT_EQ(found->inlier[static_cast<std::size_t>((3 * i + k) % count)], 0);
    EXPECT_LT((found->point_in_world - truth).norm(), 0.05);
    EXPECT_GT(found->max_angle_rad, 0.1);
    EXPECT_LT(found->rms_px, 1.2);
    EXPECT_GT(found->rms_px, 0.0);
  }
}

TEST(RobustIntersect, DisagreeingRaysHaveNoAnswer) {
  Random random(5);
  Rays rays = rays_to({0, 0, 5}, 6, 0, random);
  for (auto& xy : rays.xy) xy += random_vector(random, 0.3).head<2>();
  EXPECT_FALSE(robust_intersect(rays.cams, rays.xy, rays.focal_px, 1, 1e-3, 4));
  EXPECT_FALSE(robust_intersect(std::span(rays.cams).first(1), std::span(rays.xy).first(1),
                                std::span(rays.focal_px).first(1), 1));
}

}  // namespace
}  // namespace collinea
