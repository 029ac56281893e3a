// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/epipolar_lines.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>

#include "collinea/epipolar/scene_for_tests.h"

namespace collinea {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double distance(const EpipolarLines& lines, const Eigen::Vector2d& first, const Eigen::Vector2d& second) {
  return lines.of(first)->dot(second.homogeneous());
}

TEST(EpipolarLines, HomologousPointsLieOnThem) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const Rigid3 motion = scene::random_motion(random);
    const Eigen::Vector3d point = scene::random_point(random);
    const EpipolarLines lines(motion);
    EXPECT_NEAR(distance(lines, point.hnormalized(), scene::seen(motion, point)), 0, 1e-14);
    EXPECT_EQ(lines.sigma(point.hnormalized(), scene::seen(motion, point)), 0);
  }
}

TEST(EpipolarLines, DerivativesAreNumericOnes) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Rigid3 motion = scene::random_motion(random);
    const Eigen::Vector3d point = scene::random_point(random);
    const Eigen::Vector2d first = point.hnormalized(), second = scene::seen(motion, point);
    const Vector5 by = EpipolarLines(motion).distance_by_change(first, second);
    constexpr double h = 1e-6;
    for (int k = 0; k < 5; ++k) {
      const EpipolarLines plus(changed(motion, h * Vector5::Unit(k))), minus(changed(motion, -h * Vector5::Unit(k)));
      EXPECT_NEAR((distance(plus, first, second) - distance(minus, first, second)) / (2 * h), by[k], 1e-8);
    }
  }
}

// Two cameras that have nothing in common, with affinity and shear.
TEST(FundamentalMatrix, IsThatOfThePixels) {
  Random random(4);
  Camera first = ideal_camera(1000, 1500, 1200), second = ideal_camera(800, 1100, 900);
  second.params[Camera::kCx] += 20;
  second.params[Camera::kB1] = 3;
  second.params[Camera::kB2] = -2;
  for (int i = 0; i < 50; ++i) {
    const Rigid3 motion = scene::random_motion(random);
    const Eigen::Vector3d point = scene::random_point(random);
    const auto seen = project(first, point), from_second = project(second, motion * point);
    if (!seen || !from_second) continue;
    const auto matrix = fundamental_matrix(first, second, motion);
    ASSERT_TRUE(matrix);
    EXPECT_NEAR(matrix->norm(), 1, 1e-12);
    const Eigen::Vector3d line = *matrix * seen->homogeneous();
    EXPECT_NEAR(line.dot(from_second->homogeneous()) / line.head<2>().norm(), 0, 1e-8);  // [px]
  }
}

TEST(FundamentalMatrix, CamerasThatBendRaysHaveNone) {
  Random random(5);
  const Rigid3 motion = scene::random_motion(random);
  const Camera straight = ideal_camera(1000, 1500, 1200);
  for (const int param : {Camera::kK1, Camera::kK3, Camera::kP2}) {
    Camera bent = straight;
    bent.params[std::size_t(param)] = 1e-4;
    EXPECT_FALSE(fundamental_matrix(bent, straight, motion));
    EXPECT_FALSE(fundamental_matrix(straight, bent, motion));
  }
  Camera fisheye = straight;
  fisheye.model = Equidistant{};
  EXPECT_FALSE(fundamental_matrix(straight, fisheye, motion));
}

TEST(EpipolarLines, AnEpipoleHasNone) {
  const Rigid3 forward{Eigen::Quaterniond::Identity(), {0, 0, -1}};
  EXPECT_FALSE(EpipolarLines(forward).of({0, 0}));
  EXPECT_TRUE(EpipolarLines(forward).of({0.1, 0}));
}

// The distance of exact points from lines of an orientation with errors, over its sigma, is a standard normal variable:
// its mean square over n trials is 1 with standard deviation sqrt(2 / n).
TEST(EpipolarLines, SigmaIsThatOfTheErrorsOfTheOrientation) {
  constexpr int kTrials = 2000;
  Random random(3);
  double sum = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Rigid3 motion = scene::random_motion(random);
    Matrix5 root;
    for (int k = 0; k < 25; ++k) root(k / 5, k % 5) = 1e-4 * random.normal();
    const Matrix5 covariance = root * root.transpose();
    Vector5 error;
    for (int k = 0; k < 5; ++k) error[k] = random.normal();
    const EpipolarLines lines(changed(motion, root * error), covariance);
    const Eigen::Vector3d point = scene::random_point(random);
    const Eigen::Vector2d first = point.hnormalized(), second = scene::seen(motion, point);
    sum += std::pow(distance(lines, first, second) / lines.sigma(first, second), 2);
  }
  EXPECT_NEAR(sum / kTrials, 1, 4 * std::sqrt(2.0 / kTrials));
}

// Karfis W11: the row of an epipolar line at x = y = 75 mm of a normal pair, by the standard deviations of kappa, phi
// and omega after least squares matching. The text states 0.2 and 0.7 px of Volos (64 and 15 um), 0.7 px of Kea (49
// um); its own formulas give 0.10 and 0.41 px, and 2.35 px: errata.
TEST(EpipolarLines, RowsOfVolosAndKeaByKarfisW11) {
  const struct {
    double c_mm, omega_deg, phi_deg, kappa_deg, omega_mm, phi_mm, kappa_mm, all_mm, tolerance_mm;
    std::vector<std::pair<double, double>> pixels;  // size [mm], sigma of the row [px]
  } pairs[] = {
      {153.353, 0.0018, 0.0022, 0.0007, 0.005970, 0.001408, 0.000916, 0.00620, 5e-6, {{0.064, 0.097}, {0.015, 0.41}}},
      {152.52, 0.0344, 0.0229, 0.0057, 0.113715, 0.014740, 0.007461, 0.1149, 5e-5, {{0.049, 2.35}, {0.011, 10.4}}}};
  const Rigid3 normal_case{Eigen::Quaterniond::Identity(), {-1, 0, 0}};
  for (const auto& pair : pairs) {
    const Eigen::Vector2d at(75 / pair.c_mm, -75 / pair.c_mm);  // y down
    const auto row_mm = [&](double omega_deg, double phi_deg, double kappa_deg) {
      Vector5 sigma = Vector5::Zero();
      sigma.head<3>() = kDegree * Eigen::Vector3d(omega_deg, phi_deg, kappa_deg);
      return pair.c_mm * EpipolarLines(normal_case, Matrix5(sigma.cwiseAbs2().asDiagonal())).sigma(at, at);
    };
    EXPECT_NEAR(row_mm(pair.omega_deg, 0, 0), pair.omega_mm, 5e-7);
    EXPECT_NEAR(row_mm(0, pair.phi_deg, 0), pair.phi_mm, 5e-7);
    EXPECT_NEAR(row_mm(0, 0, pair.kappa_deg), pair.kappa_mm, 5e-7);
    const double all_mm = row_mm(pair.omega_deg, pair.phi_deg, pair.kappa_deg);
    EXPECT_NEAR(all_mm, pair.all_mm, pair.tolerance_mm);
    for (const auto& [size_mm, expected_px] : pair.pixels)
      EXPECT_NEAR(all_mm / size_mm, expected_px, expected_px < 0.1 ? 5e-4 : expected_px < 10 ? 5e-3 : 0.05);
  }
}

}  // namespace
}  // namespace collinea
