// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/image_bundles.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

struct Truth {
  ImageBundles bundles;
  std::vector<BundleMark> marks;
};

// Images that look at the points from turned attitudes; the base of the second one is of unit length.
Truth truth(Random& random, std::size_t images, std::size_t points, double sigma, bool is_turned = true,
            double shaken_rad = 0) {
  Truth out;
  out.bundles.calibration << 3000, 6, 1510, 0, 2950, 990, 0, 0, 1;
  out.bundles.cam_from_model.resize(images);
  const Vector3d middle(0, 0, 5);
  for (std::size_t i = 1; i < images; ++i) {
    const Vector3d centre =
        i == 1 ? Vector3d(0.95, 0.2, std::sqrt(1 - 0.9425)) : Vector3d(scene::random_vector(random, 1.5));
    const Vector3d to = middle - centre;
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    if (is_turned)
      rotation =
          rotation_by({0, 0, random.uniform(-1.5, 1.5)}) * Eigen::Quaterniond::FromTwoVectors(to, Vector3d::UnitZ());
    if (shaken_rad > 0) rotation = rotation_by(scene::random_vector(random, shaken_rad)) * rotation;
    out.bundles.cam_from_model[i] = {rotation, -(rotation * centre)};
  }
  while (out.bundles.points.size() < points) out.bundles.points.push_back(middle + scene::random_vector(random, 1.2));
  for (std::size_t p = 0; p < points; ++p)
    for (std::size_t i = 0; i < images; ++i) {
      const Vector3d seen = out.bundles.calibration * (out.bundles.cam_from_model[i] * out.bundles.points[p]);
      out.marks.push_back({i, p, seen.hnormalized() + scene::noise(random, sigma), sigma > 0 ? sigma : 1});
    }
  return out;
}

// Near enough for Gauss-Newton: 3 degrees, a tenth of the base, 5 % of the principal distances.
ImageBundles disturbed(const ImageBundles& bundles, Random& random, bool with_calibration) {
  ImageBundles out = bundles;
  for (std::size_t i = 1; i < out.cam_from_model.size(); ++i) {
    out.cam_from_model[i].rotation = rotation_by(scene::random_vector(random, 0.03)) * out.cam_from_model[i].rotation;
    out.cam_from_model[i].translation += scene::random_vector(random, 0.05);
  }
  out.cam_from_model[1].translation.normalize();
  for (Vector3d& point : out.points) point += scene::random_vector(random, 0.05);
  if (with_calibration) {
    out.calibration(0, 0) *= 1.04;
    out.calibration(1, 1) *= 1.05;
    out.calibration(0, 1) = 0;
    out.calibration(0, 2) += 20;
    out.calibration(1, 2) -= 30;
  }
  return out;
}

TEST(ImageBundles, ExactMeasurementsGiveTheTruth) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    const Truth t = truth(random, 4, 20, 0);
    for (const CalibrationUnknowns unknowns : {CalibrationUnknowns::kNone, CalibrationUnknowns::kAll}) {
      const bool with_calibration = unknowns == CalibrationUnknowns::kAll;
      const auto found = adjust_bundles(disturbed(t.bundles, random, with_calibration), t.marks, unknowns);
      ASSERT_TRUE(found) << found.error().message;
      EXPECT_EQ(found->redundancy, 160 - 17 - 60 - (with_calibration ? 5 : 0));
      EXPECT_LT(found->sigma0, 1e-7);  // px
      EXPECT_LT((found->bundles.calibration - t.bundles.calibration).norm(), 1e-4);
      for (std::size_t i = 0; i < 4; ++i)
        EXPECT_LT((centre_of(found->bundles.cam_from_model[i]) - centre_of(t.bundles.cam_from_model[i])).norm(), 1e-7);
    }
  }
}

TEST(ImageBundles, LocalRedundanciesAddUp) {
  Random random(3);
  const Truth t = truth(random, 3, 15, 0.5);
  const auto found = adjust_bundles(t.bundles, t.marks, CalibrationUnknowns::kFocalPoint);
  ASSERT_TRUE(found);
  double sum = 0;
  for (const BundleMarkTest& mark : found->marks) sum += mark.redundancy.sum();
  EXPECT_NEAR(sum, found->redundancy, 1e-6);
}

// e' C^-1 e of the third image with the calibration is chi-squared with 11 degrees of freedom: mean 11, standard
// deviation sqrt(22 / n). Four of those leave one false alarm in 16,000 seeds.
TEST(ImageBundles, CovarianceMatchesTheRealErrors) {
  constexpr int kSeeds = 200;
  double sum = 0, sigma0 = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const Truth t = truth(random, 4, 30, 0.3);
    const auto found = adjust_bundles(t.bundles, t.marks, CalibrationUnknowns::kAll);
    ASSERT_TRUE(found) << found.error().message;
    Eigen::Matrix<double, 11, 1> error;
    const Rigid3 &is = found->bundles.cam_from_model[2], &was = t.bundles.cam_from_model[2];
    const Matrix3d k = found->bundles.calibration - t.bundles.calibration;
    error << rotation_vector(is.rotation.conjugate() * was.rotation), centre_of(is) - centre_of(was), k(0, 0), k(1, 1),
        k(0, 1), k(0, 2), k(1, 2);
    Eigen::Matrix<double, 11, 11> covariance;
    covariance << found->covariance.block<6, 6>(12, 12), found->covariance.block<6, 5>(12, 24),
        found->covariance.block<5, 6>(24, 12), found->covariance.block<5, 5>(24, 24);
    sum += error.dot(covariance.ldlt().solve(error));
    sigma0 += found->sigma0 * found->sigma0;
  }
  EXPECT_NEAR(sum / kSeeds, 11, 4 * std::sqrt(22.0 / kSeeds));
  EXPECT_NEAR(sigma0 / kSeeds, 1, 4 * std::sqrt(2.0 / (128 * kSeeds)));  // redundancy 240 - 17 - 90 - 5
}

TEST(ImageBundles, WhatIsUndeterminedIsRefused) {
  Random random(4);
  const Truth t = truth(random, 3, 12, 0.5);
  EXPECT_FALSE(adjust_bundles(t.bundles, std::span(t.marks).first(9)));  // points without measurements
  ImageBundles one = t.bundles;
  one.cam_from_model.resize(1);
  EXPECT_FALSE(adjust_bundles(one, std::span(t.marks).first(0)));
  // Images without rotation against each other leave the principal distance open: a critical motion.
  const Truth still = truth(random, 4, 30, 0, false);
  EXPECT_TRUE(adjust_bundles(still.bundles, still.marks));
  const auto critical = adjust_bundles(still.bundles, still.marks, CalibrationUnknowns::kFocal);
  ASSERT_FALSE(critical);
  EXPECT_NE(critical.error().message.find("critical"), std::string::npos) << critical.error().message;
}

// Photographs of a strip: axes parallel but for half a degree, which noise of 1 px of 3000 does not tell from another
// principal distance. Either the steps settle, with a standard deviation that says so, or the motion is named.
TEST(ImageBundles, NearlyParallelAxesAreACriticalMotion) {
  int critical = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const Truth t = truth(random, 3, 30, 1, false, 0.01);
    const auto found = adjust_bundles(disturbed(t.bundles, random, true), t.marks, CalibrationUnknowns::kFocalPoint);
    if (found) {
      EXPECT_GT(std::sqrt(found->covariance(18, 18)), 0.05 * found->bundles.calibration(0, 0)) << seed;
      continue;
    }
    EXPECT_NE(found.error().message.find("critical"), std::string::npos) << seed << ' ' << found.error().message;
    ++critical;
  }
  EXPECT_GT(critical, 0);
}

}  // namespace
}  // namespace collinea
