// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation_angles.h"
#include "collinea/io/text.h"
#include "collinea/jobs/resection.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kDegrees = 180 / M_PI, kSigma_mm = 0.005;
const CardanAngles kAngles{0.1, -0.2, 0.6};
const Vector3d kCentre(20, -30, 900);

class LinearResection : public ::testing::Test {
 protected:
  // A photograph (y up, 150 mm, principal point off the origin) or its pixels of 10 um (y down).
  struct Asked {
    std::uint64_t seed = 1;
    bool is_plane = false, in_pixels = false, is_mirrored = false;
    int count = 20;
    std::vector<std::pair<int, Vector2d>> wrong_mm = {};
  };
  [[nodiscard]] Result<ResectionReport> resect(const Asked& asked, ResectOneOptions options) const {
    Random random(asked.seed);
    const Eigen::Matrix3d r = rotation_matrix(kAngles);
    const double per_mm = asked.in_pixels ? 100 : 1;
    const std::string unit = asked.in_pixels ? "px" : "mm";
    std::string measurements = "point x[" + unit + "] y[" + unit + "] sigma[" + unit + "]\n", ground = "point X Y Z\n";
    for (int i = 0; i < asked.count; ++i) {
      const double height = random.uniform(0, 150);
      const Vector3d point(random.uniform(-400, 400), random.uniform(-400, 400), asked.is_plane ? 0 : height);
      const Vector3d seen = r * (point - kCentre);
      Vector2d xy = -150 * seen.head<2>() / seen.z() + Vector2d(0.3, -0.2) +
                    kSigma_mm * Vector2d(random.normal(), random.normal());
      for (const auto& [index, error] : asked.wrong_mm)
        if (index == i) xy += error;
      if (asked.in_pixels != asked.is_mirrored) xy.y() = -xy.y();
      xy *= per_mm;
      const std::string name = std::to_string(i);
      measurements += name + " " + exact(xy.x()) + " " + exact(xy.y()) + " " + exact(per_mm * kSigma_mm) + "\n";
      ground += name + " " + exact(point.x()) + " " + exact(point.y()) + " " + exact(point.z()) + "\n";
    }
    EXPECT_TRUE(write_file(folder_ / "m.txt", measurements));
    EXPECT_TRUE(write_file(folder_ / "g.txt", ground));
    if (options.method == ResectionMethod::kCollinearity) options.method = ResectionMethod::kLinear;
    options.photo.principal_distance = 150 * per_mm;
    options.photo.principal_point = asked.in_pixels ? "30,20" : "0.3,-0.2";
    return resect_from_tables(folder_ / "m.txt", folder_ / "g.txt", options);
  }
  TestFolder folder_;
};

// 100 seeds: the mean of chi-squared/6 scatters by sqrt(2 / 6 / 100), of sigma0^2 by sqrt(2 / 34 / 100): four of each.
TEST_F(LinearResection, CovariancesMatchTheRealErrors) {
  constexpr int kSeeds = 100;
  for (const bool is_plane : {false, true}) {
    double sum = 0, squares = 0;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const auto report = resect({.seed = seed, .is_plane = is_plane, .in_pixels = seed % 2 == 1}, {});
      ASSERT_TRUE(report) << report.error().message;
      Eigen::Matrix<double, 6, 1> error;
      error << -kCentre, Vector3d(-kAngles.omega_rad, -kAngles.phi_rad, -kAngles.kappa_rad) * kDegrees;
      for (int k = 0; k < 6; ++k) error[k] += report->images[0].exterior[std::size_t(k)].value;
      const Eigen::Matrix<double, 6, 6> covariance = report->images[0].covariance;
      const Eigen::Matrix<double, 6, 1> unit = covariance.diagonal().cwiseSqrt().cwiseInverse();
      const Eigen::Matrix<double, 6, 6> scaled = unit.asDiagonal() * covariance * unit.asDiagonal();
      const Eigen::Matrix<double, 6, 1> e = unit.asDiagonal() * error;
      sum += e.dot(scaled.ldlt().solve(e)) / 6 / kSeeds;
      squares += std::pow(report->variance.sigma0, 2) / kSeeds;
    }
    EXPECT_NEAR(sum, 1, 4 * std::sqrt(2.0 / 6 / kSeeds)) << is_plane;
    EXPECT_NEAR(squares, 1, 4 * std::sqrt(2.0 / 34 / kSeeds)) << is_plane;
  }
}

// Errors of 3 mm are 600 standard deviations: both ways find them. The median leaves out one of 100 right ones, and
// more of few; sigma0 of 18 points is 1 within four of its standard deviations, 1 / sqrt(2 * 30).
TEST_F(LinearResection, LeavesOutWhatIsWrong) {
  for (const bool by_median : {false, true}) {
    ResectOneOptions options;
    (by_median ? options.least_median : options.reject) = true;
    const auto report = resect({.wrong_mm = {{3, {3, 0}}, {12, {-1, 2.5}}}}, options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->marks[3].is_rejected && report->marks[12].is_rejected);
    int rejected = 0;
    for (const ResectionReport::Mark& mark : report->marks) rejected += mark.is_rejected;
    EXPECT_LE(rejected, by_median ? 4 : 2);
    EXPECT_NEAR(report->variance.sigma0, 1, 4 / std::sqrt(60.0));
    // What is computed is good to some standard deviations at the edge; y of the table is up.
    EXPECT_NEAR(report->marks[12].misfit.x(), -1, 10 * kSigma_mm);
    EXPECT_NEAR(report->marks[12].misfit.y(), 2.5, 10 * kSigma_mm);
    EXPECT_NE(resection_text(*report).find("by linear equations"), std::string::npos);
  }
}

TEST_F(LinearResection, TooFewPointsAMirroredImageAndNoPrincipalDistanceAreErrors) {
  const auto few = resect({.count = 5}, {}), mirrored = resect({.is_mirrored = true}, {});
  ASSERT_FALSE(few || mirrored);
  EXPECT_EQ(few.error().code, Errc::kIllPosed);
  EXPECT_EQ(mirrored.error().code, Errc::kIllPosed);
  ResectOneOptions options;
  options.least_median = true;
  const auto four = resect({.is_plane = true, .count = 4}, options);
  ASSERT_FALSE(four);
  EXPECT_EQ(four.error().options, std::vector{"least_median"_option});
  EXPECT_TRUE(resect({.is_plane = true, .count = 4}, {}));
  options.method = ResectionMethod::kLinear;
  EXPECT_FALSE(resect_from_tables(folder_ / "m.txt", folder_ / "g.txt", options));
}

}  // namespace
}  // namespace collinea
