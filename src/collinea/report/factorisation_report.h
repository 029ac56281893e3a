// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/epipolar/image_bundles.h"
#include "collinea/epipolar/projective_factorisation.h"
#include "collinea/epipolar/self_calibration.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// Images without known orientation: projective cameras, their self-calibration and Euclidean form, and the calibrated
/// path beside it.
struct FactorisationReport {
  /// Bundles after an adjustment, for people: axes of photographs, sigmas by VarianceTest::factor().
  struct Euclidean {
    std::vector<Estimate> interior;               ///< what is estimated has a sigma
    std::vector<std::vector<Estimate>> exterior;  ///< of each image: X, Y, Z, omega, phi, kappa
    std::vector<Eigen::Vector3d> points, sigma_points;
    std::vector<BundleMarkTest> marks;  ///< point by point, in the axes of the table
    VarianceTest variance;
    double conditioning = 0;
    int iterations = 0;
  };
  /// An image in both: self-calibrated less calibrated.
  struct Difference {
    double centre = 0;                                ///< length, in units of the base
    double rotation_deg = 0;                          ///< angle
    double sigma_centre = 0, sigma_rotation_deg = 0;  ///< root of the trace of the self-calibrated covariance
  };
  std::string unit;  ///< px or mm
  bool y_up = false;
  std::vector<std::string> images, points;
  std::vector<std::string> left_out;  ///< points that not all images show
  std::vector<std::string> rejected;  ///< points that contradict the others
  std::size_t unit_base = 1;          ///< the image whose distance from the first one is 1
  ProjectiveModel projective;         ///< in the axes of the table
  VarianceTest projective_variance;
  std::vector<PairFundamental> pairs;
  std::vector<Estimate> from_fundamentals;  ///< interior orientation; empty where the pairs do not state it
  double upgrade_misfit = 0;
  std::optional<Euclidean> self_calibrated;
  std::string why_not_euclidean;  ///< where a self-calibration was asked for and there is none
  std::optional<Euclidean> calibrated;
  std::string why_not_calibrated;
  std::vector<Difference> differences;
  std::vector<Finding> findings;
};

/// Whether what binds an adjustment further costs more than errors of measurement allow: F by the squares that it adds.
struct ConditionTest {
  int conditions = 0;
  double ratio = 0, chance = 1;

  [[nodiscard]] bool is_refuted() const { return chance < VarianceTest::kLevel; }
};
/// Nothing where no condition is added, or nothing checks the free one.
[[nodiscard]] std::optional<ConditionTest> test_of_conditions(const VarianceTest& free, const VarianceTest& bound);

[[nodiscard]] std::string factorisation_text(const FactorisationReport& report);
/// projective cameras, projective points, their residuals, pairs; where they are: interior, exterior, points and
/// residuals of the self-calibration, exterior of the calibrated path.
[[nodiscard]] std::vector<NamedTable> factorisation_tables(const FactorisationReport& report);

}  // namespace collinea
