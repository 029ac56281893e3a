// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/oriented_intersection.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

const Camera kCamera = ideal_camera(3000, 4000, 3000);
const Vector3d kPoint(5, -4, 2);

Rigid3 pose_of(int i) {
  const Rigid3 pose{cam_from_world({4.0 - 3 * i, -5.0 + 4 * i, 30.0 * i}), {0, 0, 0}};
  const Vector3d centre(20.0 * i - 30, 6.0 * (i % 2), 100 + 2.0 * i);
  return {pose.rotation, -(pose.rotation * centre)};
}

Rigid3 moved(const Rigid3& pose, const Vector6& by) {
  const Eigen::Quaterniond rotation = pose.rotation * rotation_by(-by.head<3>());
  return {rotation, -(rotation * (centre_of(pose) + by.tail<3>()))};
}

std::vector<UncertainSightLine> lines_with(int count, double sigma_px, double sigma_rad, double sigma_m,
                                           Random& random) {
  std::vector<UncertainSightLine> lines;
  for (int i = 0; i < count; ++i) {
    UncertainSightLine one;
    Vector6 sigma, error;
    sigma << Vector3d::Constant(sigma_rad), Vector3d::Constant(sigma_m);
    for (int k = 0; k < 6; ++k) error[k] = sigma[k] * random.normal();
    one.line = {&kCamera,
                moved(pose_of(i), error),
                *project(kCamera, pose_of(i) * kPoint) + sigma_px * Vector2d(random.normal(), random.normal()),
                std::max(sigma_px, 1e-3),
                {}};
    one.pose_covariance = sigma.cwiseAbs2().asDiagonal();
    lines.push_back(one);
  }
  return lines;
}

TEST(OrientedIntersection, ExactRaysMeetInThePoint) {
  Random random(1);
  for (const int count : {2, 3, 4, 5}) {
    const auto found = intersect_oriented(lines_with(count, 0, 0, 0, random));
    ASSERT_TRUE(found);
    EXPECT_LT((found->point_in_world - kPoint).norm(), 1e-9);
    EXPECT_EQ(found->redundancy, 2 * count - 3);  // Mussio D.8: 1, 3, 5, 7 for N = 2, 3, 4, 5
    double redundancy = 0;
    for (const RayTest& ray : found->rays) redundancy += ray.redundancy.sum();
    EXPECT_NEAR(redundancy, found->redundancy, 1e-6);
  }
}

TEST(OrientedIntersection, CovarianceMatchesTheRealErrorsOfPixelsAndOrientations) {
  for (const double sigma_rad : {0.0, 3e-4}) {
    constexpr int kSeeds = 500;
    double sum = 0, squares = 0, tests = 0;
    int inside = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
      Random random(static_cast<std::uint64_t>(seed));
      const auto found = intersect_oriented(lines_with(4, 0.6, sigma_rad, 100 * sigma_rad, random));
      ASSERT_TRUE(found);
      const Vector3d error = found->point_in_world - kPoint;
      const double chi2 = error.dot(found->covariance.ldlt().solve(error));
      sum += chi2 / 3;
      inside += chi2 < 7.815;
      squares += found->sigma0 * found->sigma0;
      for (const RayTest& ray : found->rays) tests += ray.w.squaredNorm() / 8;
    }
    EXPECT_NEAR(sum / kSeeds, 1, 0.1);
    EXPECT_NEAR(squares / kSeeds, 1, 0.08);
    EXPECT_NEAR(tests / kSeeds, 1, 0.08);
    EXPECT_NEAR(double(inside) / kSeeds, 0.95, 0.02);
  }
}

TEST(OrientedIntersection, ParallelAndSingleRaysAreRefused) {
  Random random(1);
  auto lines = lines_with(2, 0.5, 0, 0, random);
  EXPECT_FALSE(intersect_oriented(std::span(lines).first(1)));
  lines[1] = lines[0];
  EXPECT_FALSE(intersect_oriented(lines));
}

}  // namespace
}  // namespace collinea
