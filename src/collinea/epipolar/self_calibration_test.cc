// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/self_calibration.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "collinea/epipolar/survey_for_tests.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

const Vector2d kMiddle(1500, 1000);  // what is known of the principal point: 10 px off

Matrix3d start_of(double focal, const Vector2d& point) {
  Matrix3d k = Matrix3d::Identity();
  k(0, 0) = k(1, 1) = focal;
  k.topRightCorner<2, 1>() = point;
  return k;
}

// Square pixels, so that one principal distance is the truth.
SelfCalibrationTruth square_truth(const SelfCalibrationScene& scene) {
  SelfCalibrationTruth truth = self_calibration_truth(scene);
  const Matrix3d k = start_of(3000, {1510, 990}), change = k * truth.bundles.calibration.inverse();
  truth.bundles.calibration = k;
  for (std::size_t i = 0; i < truth.measured.images(); ++i) {
    truth.matrices[i] = change * truth.matrices[i];
    for (Eigen::Index p = 0; p < truth.measured.points(); ++p)
      truth.measured.xy[i].col(p) = (change * Vector2d(truth.measured.xy[i].col(p)).homogeneous()).hnormalized();
  }
  return truth;
}

TEST(SelfCalibration, PrincipalDistanceOfAFundamentalMatrix) {
  int found = 0, pairs = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SelfCalibrationTruth truth = square_truth({.images = 4, .points = 10, .seed = seed});
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j) {
        const auto focal = focal_from_fundamental(fundamental_of(truth.matrices[i], truth.matrices[j]), {1510, 990});
        ++pairs;
        found += focal && std::abs(*focal - 3000) < 1e-3;
      }
  }
  EXPECT_EQ(found, pairs);
}

// Parallel axes leave the principal distance open, whatever the base.
TEST(SelfCalibration, ParallelAxesStateNoPrincipalDistance) {
  const SelfCalibrationTruth truth = square_truth({.images = 2, .points = 10, .is_turned = false});
  EXPECT_FALSE(focal_from_fundamental(fundamental_of(truth.matrices[0], truth.matrices[1]), {1510, 990}));
  EXPECT_FALSE(focal_from_fundamental(Matrix3d::Zero(), {0, 0}));
}

TEST(SelfCalibration, CalibrationOfFundamentalMatricesIsTheTruth) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SelfCalibrationTruth truth = self_calibration_truth({.images = 5, .points = 30, .seed = seed});
    const auto pairs = fundamentals_of_pairs(truth.measured, kMiddle);
    ASSERT_EQ(pairs.size(), 10u);
    const auto k = calibration_from_fundamentals(pairs, start_of(2600, kMiddle), CalibrationUnknowns::kAll);
    ASSERT_TRUE(k);
    EXPECT_LT((*k - truth.bundles.calibration).norm(), 0.05) << *k;
  }
  const SelfCalibrationTruth truth = self_calibration_truth({.images = 2, .points = 30});
  const auto one = fundamentals_of_pairs(truth.measured, kMiddle);
  EXPECT_FALSE(calibration_from_fundamentals(one, start_of(2600, kMiddle), CalibrationUnknowns::kAll));
}

TEST(SelfCalibration, ExactMeasurementsGiveCalibrationAndCameras) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SelfCalibrationTruth truth = self_calibration_truth({.images = 5, .points = 30, .seed = seed});
    const auto model = factorised(truth.measured);
    ASSERT_TRUE(model);
    const auto upgrades = euclidean_upgrades(*model, kMiddle, 1500, CalibrationUnknowns::kAll);
    ASSERT_FALSE(upgrades.empty());
    EXPECT_EQ(upgrades[0].in_front, 30);
    EXPECT_LT((upgrades[0].bundles.calibration - truth.bundles.calibration).norm(), 0.1);
    const auto found = self_calibrated(*model, truth.measured, upgrades, CalibrationUnknowns::kAll, 1);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT((found->bundles.calibration - truth.bundles.calibration).norm(), 1e-3);
    for (std::size_t i = 0; i < 5; ++i) {
      const Rigid3 &is = found->bundles.cam_from_model[i], &was = truth.bundles.cam_from_model[i];
      EXPECT_LT((centre_of(is) - centre_of(was)).norm(), 1e-6);
      EXPECT_LT(angle_between(is.rotation, was.rotation), 1e-6);
    }
    const auto by_camera = calibrated(truth.measured, truth.bundles.calibration, 1, 1);
    ASSERT_TRUE(by_camera) << by_camera.error().message;
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_LT((centre_of(by_camera->bundles.cam_from_model[i]) - centre_of(truth.bundles.cam_from_model[i])).norm(),
                1e-7);
  }
}

// e' C^-1 e of the calibration is chi-squared with 5 degrees of freedom, mean 5 with standard deviation sqrt(10 / n).
// All seeds must find it from the measurements alone.
TEST(SelfCalibration, CovarianceOfTheCalibrationIsTrue) {
  constexpr int kSeeds = 160;
  double sum = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const SelfCalibrationTruth truth = self_calibration_truth({.images = 6, .points = 40, .sigma = 0.3, .seed = seed});
    const auto model = factorised(truth.measured);
    ASSERT_TRUE(model) << seed << ": " << model.error().message;
    const auto upgrades = euclidean_upgrades(*model, kMiddle, 1500, CalibrationUnknowns::kAll);
    const auto found = self_calibrated(*model, truth.measured, upgrades, CalibrationUnknowns::kAll, 1);
    ASSERT_TRUE(found) << seed << ": " << found.error().message;
    const Matrix3d off = found->bundles.calibration - truth.bundles.calibration;
    Eigen::Matrix<double, 5, 1> error;
    error << off(0, 0), off(1, 1), off(0, 1), off(0, 2), off(1, 2);
    sum += error.dot(found->covariance.bottomRightCorner<5, 5>().ldlt().solve(error));
  }
  EXPECT_NEAR(sum / kSeeds, 5, 4 * std::sqrt(10.0 / kSeeds));
}

TEST(SelfCalibration, CriticalMotionsAndTwoImagesAreRefused) {
  const SelfCalibrationTruth still = square_truth({.images = 4, .points = 30, .is_turned = false});
  const auto model = factorised(still.measured);
  ASSERT_TRUE(model) << model.error().message;
  const auto upgrades = euclidean_upgrades(*model, kMiddle, 1500, CalibrationUnknowns::kFocal);
  EXPECT_FALSE(self_calibrated(*model, still.measured, upgrades, CalibrationUnknowns::kFocal, 1));
  const SelfCalibrationTruth pair = self_calibration_truth({.images = 2, .points = 30});
  const auto two = factorised(pair.measured);
  ASSERT_TRUE(two) << two.error().message;
  EXPECT_TRUE(euclidean_upgrades(*two, kMiddle, 1500, CalibrationUnknowns::kFocal).empty());
  EXPECT_FALSE(self_calibrated(*two, pair.measured, {}, CalibrationUnknowns::kFocal, 1));
}

}  // namespace
}  // namespace collinea
