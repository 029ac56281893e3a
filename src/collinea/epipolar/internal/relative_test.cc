// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/relative.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/internal/fundamental.h"
#include "collinea/epipolar/internal/homography.h"
#include "collinea/epipolar/scene_for_tests.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

using namespace scene;

Rigid3 disturbed(const Rigid3& motion, double by, Random& random) {
  return {rotation_by(random_vector(random, by)) * motion.rotation,
          (motion.translation + random_vector(random, by)).normalized()};
}

double pose_distance(const Rigid3& a, const Rigid3& b) {
  return std::max(angle_between(a.rotation, b.rotation), (a.translation - b.translation).norm());
}

TEST(EpipolarErrors, AreDistancesInPixels) {
  // Pure sideways motion: epipolar lines are rows, and a pair whose rows differ by d is d / sqrt(2) from the nearest
  // exact one.
  const Rigid3 motion{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  PointPairs pairs;
  pairs.focal_first_px = pairs.focal_second_px = 500;
  pairs.add({0.1, 0.2}, {-0.05, 0.21});
  double squared = 0;
  squared_epipolar_errors(7 * essential_matrix(motion), pairs, 0, 1, &squared);
  EXPECT_NEAR(squared, 25.0 / 2, 1e-10);
}

// The formula as it is written, pair by pair, has the bits of every instruction set: limits of searches lie on them.
TEST(EpipolarErrors, HaveTheSameBitsOnEveryInstructionSet) {
  Random random(9);
  const Rigid3 motion = random_motion(random);
  PointPairs pairs = pairs_of(motion, 107, 1, random, random_point);  // whole vectors of each width, and a rest
  pairs.focal_second_px *= 1.3;
  PointPairs fisheyes = pairs;
  for (int i = 0; i < pairs.size(); ++i) {
    fisheyes.scale1.push_back(random.uniform(0.5, 1));
    fisheyes.scale2.push_back(random.uniform(0.5, 1));
  }
  const Eigen::Matrix3d m = essential_matrix(motion);
  for (const PointPairs& images : {pairs, fisheyes}) {
    std::vector<double> plain;
    for (int i = 7; i < images.size(); ++i) {
      const Eigen::Vector2d p = images.first(i), q = images.second(i), pixels = images.squared_pixels(i);
      const double a = m(0, 0) * p.x() + m(0, 1) * p.y() + m(0, 2), b = m(1, 0) * p.x() + m(1, 1) * p.y() + m(1, 2);
      const double third = m(2, 0) * p.x() + m(2, 1) * p.y() + m(2, 2);
      const double u = m(0, 0) * q.x() + m(1, 0) * q.y() + m(2, 0), v = m(0, 1) * q.x() + m(1, 1) * q.y() + m(2, 1);
      const double c = q.x() * a + q.y() * b + third;
      plain.push_back(c * c / (pixels[1] * (a * a + b * b) + pixels[0] * (u * u + v * v)));
    }
    for (const std::int64_t target : collinea::testing::processor_targets()) {
      const collinea::testing::OnTarget on(target);
      std::vector<double> squared(plain.size());
      squared_epipolar_errors(m, images, 7, images.size(), squared.data());
      EXPECT_EQ(squared, plain) << target;
    }
  }
}

TEST(RefineRelative, ReturnsToTheExactMotion) {
  Random random(1);
  for (int world = 0; world < 50; ++world) {
    const Rigid3 truth = random_motion(random);
    const PointPairs pairs = pairs_of(truth, 60, 0, random, random_point);
    const auto fit = refine_relative(disturbed(truth, 0.02, random), pairs, everyone(pairs), 50);
    ASSERT_TRUE(fit);
    EXPECT_LT(pose_distance(fit->second_from_first, truth), 1e-8);
    EXPECT_NEAR(fit->second_from_first.translation.norm(), 1, 1e-12);
  }
}

// At the answer the gradient of the cost vanishes along every direction: checks the derivatives against numeric costs.
TEST(RefineRelative, AnswerIsAMinimumOfTheCost) {
  Random random(2);
  const Rigid3 truth = random_motion(random);
  const PointPairs pairs = pairs_of(truth, 80, 1, random, random_point);
  const double loss_px = 3;
  const auto fit = refine_relative(truth, pairs, everyone(pairs), loss_px);
  ASSERT_TRUE(fit);
  const auto cost = [&](const Rigid3& motion) {
    std::vector<double> e(80);
    squared_epipolar_errors(essential_matrix(motion), pairs, 0, 80, e.data());
    double sum = 0;
    for (const double squared : e) sum += squared / (1 + squared / (loss_px * loss_px));
    return sum;
  };
  const double least = cost(fit->second_from_first);
  EXPECT_NEAR(std::sqrt(least / 80), fit->rms_px, 1e-9);
  for (int k = 0; k < 20; ++k) EXPECT_GT(cost(disturbed(fit->second_from_first, 1e-4, random)), least);
}

// The weighted error e' C^-1 e is chi-squared with five degrees of freedom: mean 5, standard deviation sqrt(10 / n) of
// the mean. The wide loss makes the robust weights 1. Rotation errors are in the second frame, translation errors along
// the tangents of the answer.
TEST(RefineRelative, CovarianceMatchesTheRealErrors) {
  Random random(3);
  double sum = 0;
  constexpr int kTimes = 400;
  for (int k = 0; k < kTimes; ++k) {
    const Rigid3 truth = random_motion(random);
    const PointPairs pairs = pairs_of(truth, 100, 0.3, random, random_point);
    const auto fit = refine_relative(truth, pairs, everyone(pairs), 1e3);
    ASSERT_TRUE(fit);
    const Eigen::Vector3d t = fit->second_from_first.translation;
    int smallest = 0;
    t.cwiseAbs().minCoeff(&smallest);
    const Eigen::Vector3d u = t.cross(Eigen::Vector3d::Unit(smallest)).normalized(), v = t.cross(u).normalized();
    Eigen::Matrix<double, 5, 1> e;
    e << rotation_vector(truth.rotation * fit->second_from_first.rotation.conjugate()), u.dot(truth.translation),
        v.dot(truth.translation);
    sum += e.dot((0.09 * fit->covariance).ldlt().solve(e));
  }
  EXPECT_NEAR(sum / kTimes, 5, 4 * std::sqrt(10.0 / kTimes));
}

TEST(RefineRelative, ErrorsGrowWithTheNoise) {
  const auto mean_error = [](double sigma_px) {
    Random random(4);
    double sum = 0;
    for (int k = 0; k < 60; ++k) {
      const Rigid3 truth = random_motion(random);
      const PointPairs pairs = pairs_of(truth, 100, sigma_px, random, random_point);
      sum += pose_distance(refine_relative(truth, pairs, everyone(pairs), 100)->second_from_first, truth);
    }
    return sum / 60;
  };
  EXPECT_NEAR(mean_error(0.2) / mean_error(0.1), 2, 0.1);  // the same worlds and numbers, doubled
}

TEST(RefineRelative, TooFewPairsOrALineHaveNoAnswer) {
  Random random(5);
  const Rigid3 truth = random_motion(random);
  const PointPairs few = pairs_of(truth, 4, 0, random, random_point);
  EXPECT_FALSE(refine_relative(truth, few, everyone(few), 2));
  const PointPairs line = pairs_of(truth, 30, 0, random, [](Random& r) {
    const double s = r.uniform(-1, 1);
    return Eigen::Vector3d(s, 0.3 * s, 5);
  });
  EXPECT_FALSE(refine_relative(truth, line, everyone(line), 2));
}

TEST(RefineRelativeAndFocal, FindsTheFactorOfTheFocalLength) {
  Random random(10);
  for (int world = 0; world < 20; ++world) {
    const Rigid3 truth = random_motion(random);
    const PointPairs right = pairs_of(truth, 200, 0, random, random_point);
    PointPairs wrong = right;
    const double factor = world % 2 ? 1.1 : 0.9;  // the focal length in use times this is the right one
    wrong.focal_first_px /= factor;
    wrong.focal_second_px /= factor;
    for (auto* values : {&wrong.x1, &wrong.y1, &wrong.x2, &wrong.y2})
      for (double& value : *values) value *= factor;
    const auto fit =
        refine_relative_and_focal(disturbed(truth, 0.02, random), wrong, everyone(wrong), 50, {true, true, 1e3});
    ASSERT_TRUE(fit);
    EXPECT_NEAR(fit->focal_factor, factor, 1e-5);
    EXPECT_LT(pose_distance(fit->second_from_first, truth), 1e-4);
    const auto fixed = refine_relative_and_focal(truth, right, everyone(right), 50, {true, true, 1e-6});
    EXPECT_NEAR(fixed->focal_factor, 1, 1e-9);
  }
}

TEST(RefineFundamental, ReturnsToTheExactMatrixAndKeepsRankTwo) {
  Random random(6);
  for (int world = 0; world < 20; ++world) {
    const Rigid3 truth = random_motion(random);
    const PointPairs pairs = pairs_of(truth, 60, 0, random, random_point);
    const auto start = eight_point(pairs_of(truth, 60, 0.5, random, random_point), everyone(pairs));
    ASSERT_TRUE(start);
    const auto fit = refine_fundamental(*start, pairs, everyone(pairs), 50);
    ASSERT_TRUE(fit);
    EXPECT_LT(distance_up_to_scale(*fit, essential_matrix(truth)), 1e-6);
    EXPECT_LT(std::abs(fit->determinant()), 1e-14);
  }
}

TEST(RefineFundamental, IsBetterThanTheLinearAnswer) {
  Random random(7);
  double linear = 0, refined = 0;
  for (int world = 0; world < 30; ++world) {
    const Rigid3 truth = random_motion(random);
    const PointPairs pairs = pairs_of(truth, 60, 1, random, random_point);
    const auto start = eight_point(pairs, everyone(pairs));
    const auto fit = refine_fundamental(*start, pairs, everyone(pairs), 1e3);
    linear += distance_up_to_scale(*start, essential_matrix(truth));
    refined += distance_up_to_scale(*fit, essential_matrix(truth));
  }
  EXPECT_LT(refined, linear);
}

TEST(RefineHomography, ReturnsToTheExactOneAndIsAMinimumWithNoise) {
  Random random(8);
  const Rigid3 motion = random_motion(random);
  const PointPairs exact = pairs_of(motion, 40, 0, random, random_point_on_plane);
  const auto truth = four_point({exact.first(0), exact.first(1), exact.first(2), exact.first(3)},
                                {exact.second(0), exact.second(1), exact.second(2), exact.second(3)});
  ASSERT_TRUE(truth);
  const Eigen::Matrix3d start = *truth + 0.003 * Eigen::Matrix3d::Ones();
  const auto fit = refine_homography(start, exact, everyone(exact), 50);
  ASSERT_TRUE(fit);
  EXPECT_LT(distance_up_to_scale(*fit, *truth), 1e-8);

  const PointPairs noisy = pairs_of(motion, 40, 1, random, random_point_on_plane);
  const auto best = refine_homography(*truth, noisy, everyone(noisy), 1e3);
  const auto cost = [&](const Eigen::Matrix3d& h) {
    std::vector<double> e(40);
    squared_errors(h, noisy, 0, 40, e.data());
    double sum = 0;
    for (const double squared : e) sum += squared;
    return sum;
  };
  // 80 residuals, 8 unknowns: chi-squared with 72 degrees of freedom, standard deviation 12.
  EXPECT_NEAR(cost(*best), 72, 4 * 12);
  EXPECT_LT(cost(*best), cost(*truth));
}

TEST(RefineRotation, ReturnsToTheExactOne) {
  Random random(9);
  const Eigen::Quaterniond truth = rotation_by({0.1, -0.2, 0.05});
  const PointPairs pairs = pairs_of({truth, {0, 0, 0}}, 30, 0, random, random_point);
  const auto fit = refine_rotation(rotation_by({0.02, 0.01, -0.01}) * truth, pairs, everyone(pairs), 50);
  ASSERT_TRUE(fit);
  EXPECT_LT(angle_between(*fit, truth), 1e-10);
  EXPECT_FALSE(refine_rotation(truth, pairs, std::vector<int>{3}, 2));
}

}  // namespace
}  // namespace collinea
