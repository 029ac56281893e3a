// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/given_coplanarity.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSigma = 3e-5;

Vector3d drawn(Random& random, double size) {
  return size * Vector3d(random.normal(), random.normal(), random.normal());
}

Rigid3 pose_at(const Vector3d& centre, const Vector3d& turn) {
  Rigid3 pose;
  pose.rotation = rotation_by(turn);
  pose.translation = -(pose.rotation * centre);
  return pose;
}

// Points in front of both cameras, with noise.
std::vector<PairPoint> measured(const std::array<Rigid3, 2>& poses, int count, double sigma, Random& random) {
  std::vector<PairPoint> points;
  while (points.size() < static_cast<std::size_t>(count)) {
    const Vector3d in_first(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(2, 4));
    const Vector3d in_second = poses[1] * (inverse(poses[0]) * (300 * in_first));
    if (in_second.z() < 100) continue;
    const auto noise = [&]() -> Vector2d { return sigma * Vector2d(random.normal(), random.normal()); };
    points.push_back({in_first.hnormalized() + noise(), in_second.hnormalized() + noise(), kSigma, kSigma});
  }
  return points;
}

TEST(GivenCoplanarity, ExactPointsHaveNone) {
  Random random(1);
  const std::array<Rigid3, 2> poses{pose_at({400, -300, 1000}, {0.3, 0.1, -2}),
                                    pose_at({450, -291, 996}, {0.35, 0.05, -1.9})};
  for (const PointCoplanarity& one : given_coplanarity(measured(poses, 20, 0, random), poses, Matrix5::Zero()).points) {
    EXPECT_NEAR(one.symmetric, 0, 1e-12);  // rounding of coordinates of a thousand in units of the base
    EXPECT_NEAR(one.exterior, 0, 1e-10);
  }
}

// Whatever the points, the three differ by the lengths of their bases: up to rounding.
TEST(GivenCoplanarity, TheThreeFormsAreOneConditionOfThreeBases) {
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const std::array<Rigid3, 2> poses{pose_at(drawn(random, 100), drawn(random, 0.5)),
                                      pose_at(drawn(random, 100), drawn(random, 0.5))};
    const double base = (centre_of(poses[1]) - centre_of(poses[0])).norm();
    const double along_x = std::abs(base_in_first(poses[1] * inverse(poses[0])).x());
    std::vector<PairPoint> points;
    for (int i = 0; i < 5; ++i)
      points.push_back({drawn(random, 0.5).head<2>(), drawn(random, 0.5).head<2>(), kSigma, kSigma});
    for (const PointCoplanarity& one : given_coplanarity(points, poses, Matrix5::Zero()).points) {
      EXPECT_NEAR(one.exterior, base * one.symmetric, 1e-10 * base);
      ASSERT_TRUE(one.dependent);
      EXPECT_NEAR(*one.dependent, one.symmetric / along_x, 1e-10 / along_x);
    }
  }
}

TEST(GivenCoplanarity, ABaseAlongTheViewHasItsConditionToo) {
  Random random(2);
  const std::array<Rigid3, 2> poses{pose_at({0, 0, 0}, {0, 0, 0}), pose_at({0, 0, 60}, {0.01, 0.02, 0})};
  Matrix5 covariance = 1e-10 * Matrix5::Identity();
  const GivenCoplanarity found = given_coplanarity(measured(poses, 8, kSigma, random), poses, covariance);
  for (const PointCoplanarity& one : found.points) {
    EXPECT_FALSE(one.dependent);
    EXPECT_TRUE(std::isfinite(one.w) && one.sigma > 0);
  }
}

// A change of the motion by `step` changes the condition as its derivative says, which is what sigma holds of the
// elements.
TEST(GivenCoplanarity, SigmaFollowsTheCondition) {
  Random random(3);
  const std::array<Rigid3, 2> poses{pose_at({0, 0, 0}, {0, 0, 0}), pose_at({80, 10, -5}, {0.05, -0.1, 0.2})};
  auto points = measured(poses, 6, 1e-4, random);
  for (PairPoint& point : points) point.sigma_first = point.sigma_second = 1e-12;
  Rigid3 motion = poses[1];
  motion.translation.normalize();
  for (int k = 0; k < 5; ++k) {
    const double step = 1e-6;
    Matrix5 covariance = Matrix5::Zero();
    covariance(k, k) = step * step;
    const auto at = [&](double by) {
      return given_coplanarity(points, {Rigid3{}, changed(motion, by * Vector5::Unit(k))}, Matrix5::Zero()).points;
    };
    const auto more = at(step), less = at(-step), here = given_coplanarity(points, poses, covariance).points;
    for (std::size_t i = 0; i < points.size(); ++i)
      EXPECT_NEAR(here[i].sigma, std::abs(more[i].symmetric - less[i].symmetric) / 2, 1e-9 * step + 1e-11);
  }
}

// The gap, taken off along the gradient of the condition by the four coordinates, makes the rays meet but for what is
// of second order: the condition is linear in the coordinates of either ray, what is left is d1' E d2 with the
// changes d1, d2 of both and E of a unit base, thus gap^2 / 2 at most. Rounding: some 1e-16 of coordinates of 1.
TEST(GivenCoplanarity, TheGapIsTheShortestWayToRaysThatMeet) {
  Random random(3);
  const std::array<Rigid3, 2> poses{pose_at({0, 0, 0}, {0, 0, 0}), pose_at({80, 10, -5}, {0.05, -0.1, 0.2})};
  for (const double noise : {1e-4, 1e-2})
    for (const PairPoint& point : measured(poses, 20, noise, random)) {
      const auto moved = [&](const Eigen::Vector4d& by) {
        PairPoint at = point;
        at.first += by.head<2>();
        at.second += by.tail<2>();
        return given_coplanarity(std::span(&at, 1), poses, Matrix5::Zero()).points[0];
      };
      const PointCoplanarity here = moved(Eigen::Vector4d::Zero());
      Eigen::Vector4d gradient;  // central differences of what is linear in each: exact
      for (int k = 0; k < 4; ++k)
        gradient(k) =
            (moved(0.1 * Eigen::Vector4d::Unit(k)).symmetric - moved(-0.1 * Eigen::Vector4d::Unit(k)).symmetric) / 0.2;
      const double left = moved(-here.gap * gradient.normalized()).symmetric;
      EXPECT_LE(std::abs(left), here.gap * here.gap / 2 + 1e-15);
      EXPECT_GT(std::abs(here.symmetric), 4 * here.gap * here.gap);  // far more than what is left
    }
}

// Elements and measurements with errors of their sigmas: n sigma0^2 is chi-squared with n degrees, 12 in the mean with
// a standard deviation of sqrt(2 * 12 / 400) over the trials; w has the variance 1 with sqrt(2 / 4800), more because
// those of a trial are correlated: of the worst case, all alike, sqrt(2 / 400). Four of each.
TEST(GivenCoplanarity, TestsMatchTheRealErrors) {
  const std::array<Rigid3, 2> truth{pose_at({0, 0, 0}, {0, 0, 0}), pose_at({200, 10, -5}, {0.05, -0.1, 0.2})};
  Rigid3 motion = truth[1];
  motion.translation.normalize();
  Eigen::Matrix<double, 5, 5> root = Matrix5::Zero();
  root.diagonal() << 4e-5, 3e-5, 6e-5, 5e-5, 2e-5;
  root(3, 0) = 3e-5;
  root(4, 2) = -4e-5;
  const Matrix5 covariance = root * root.transpose();
  double of_all = 0, of_one = 0;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Random random(seed, 7);
    const auto points = measured(truth, 12, kSigma, random);
    Vector5 change;
    for (int k = 0; k < 5; ++k) change(k) = random.normal();
    const GivenCoplanarity found = given_coplanarity(points, {Rigid3{}, changed(motion, root * change)}, covariance);
    of_all += 12 * found.sigma0 * found.sigma0;
    for (const PointCoplanarity& one : found.points) of_one += one.w * one.w / 12;
  }
  EXPECT_NEAR(of_all / 400, 12, 4 * std::sqrt(2 * 12 / 400.0));
  EXPECT_NEAR(of_one / 400, 1, 4 * std::sqrt(2 / 400.0));
}

}  // namespace
}  // namespace collinea
