// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/projective_factorisation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "collinea/epipolar/internal/essential.h"
#include "collinea/epipolar/scene_for_tests.h"
#include "collinea/epipolar/survey_for_tests.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(Factorisation, ExactMeasurementsHaveRankFour) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SelfCalibrationTruth truth = self_calibration_truth({.images = 5, .points = 30, .seed = seed});
    const auto model = factorised(truth.measured);
    ASSERT_TRUE(model) << model.error().message;
    EXPECT_LT(model->fifth, 1e-4 * model->fourth);
    EXPECT_LT(model->sigma0, 1e-6);  // px
    EXPECT_EQ(model->redundancy, 2 * 5 * 30 - 11 * 5 - 3 * 30 + 15);
    // The epipolar geometry is that of the true cameras, whatever the collineation.
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t j = i + 1; j < 5; ++j)
        EXPECT_LT(scene::distance_up_to_scale(fundamental_of(model->matrices[i], model->matrices[j]),
                                              fundamental_of(truth.matrices[i], truth.matrices[j])),
                  1e-8);
  }
}

// sigma0^2 times the redundancy is chi-squared: its mean is 1 with standard deviation sqrt(2 / sum of redundancies).
TEST(Factorisation, SigmaOfTheImagesIsFound) {
  constexpr int kSeeds = 40;
  double squares = 0, redundancy = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto model =
        factorised(self_calibration_truth({.images = 4, .points = 25, .sigma = 0.4, .seed = seed}).measured);
    ASSERT_TRUE(model) << model.error().message;
    squares += model->sigma0 * model->sigma0 * model->redundancy;
    redundancy += model->redundancy;
  }
  EXPECT_NEAR(squares / redundancy, 1, 4 * std::sqrt(2 / redundancy));
}

// F = K'^-T [t]x R K^-1 (Bolognesi 5.26-5.28).
TEST(Factorisation, FundamentalMatrixOfTwoCamerasHoldsTheirEssentialOne) {
  const SelfCalibrationTruth truth = self_calibration_truth({.images = 2, .points = 10, .seed = 3});
  const Matrix3d inverse = truth.bundles.calibration.inverse();
  const Rigid3 motion = truth.bundles.cam_from_model[1];
  EXPECT_LT(scene::distance_up_to_scale(fundamental_of(truth.matrices[0], truth.matrices[1]),
                                        inverse.transpose() * essential_matrix(motion) * inverse),
            1e-10);
}

TEST(Factorisation, PlanesOneCentreAndFewPointsAreRefused) {
  EXPECT_FALSE(factorised(self_calibration_truth({.images = 3, .points = 7}).measured));
  EXPECT_FALSE(factorised(self_calibration_truth({.images = 1, .points = 20}).measured));
  for (const double sigma : {0.0, 0.3}) {
    const auto flat =
        factorised(self_calibration_truth({.images = 4, .points = 30, .sigma = sigma, .is_flat = true}).measured);
    ASSERT_FALSE(flat) << sigma;
    EXPECT_NE(flat.error().message.find("plane"), std::string::npos);
    EXPECT_FALSE(factorised(
        self_calibration_truth({.images = 4, .points = 30, .sigma = sigma, .has_one_centre = true}).measured));
  }
}

}  // namespace
}  // namespace collinea
