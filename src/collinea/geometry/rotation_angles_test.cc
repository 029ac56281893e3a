// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/rotation_angles.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "collinea/geometry/rotation.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
constexpr double kPi = std::numbers::pi;

double apart(const Matrix3d& a, const Matrix3d& b) { return (a - b).cwiseAbs().maxCoeff(); }

Matrix3d rows(const std::array<double, 9>& v) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(v.data());
}

TEST(RotationAngles, MatricesOfMussioD8) {
  EXPECT_LT(apart(rotation_matrix(CardanAngles{0.3, -0.4, 0.7}),
                  rows({0.7044663053, 0.5274258682, 0.4749201809, -0.5933637834, 0.8048188585, -0.0136391194,
                        -0.3894183423, -0.2721921353, 0.8799231763})),
            5.1e-11);
  EXPECT_LT(apart(rotation_matrix(EulerAngles{0.5, 1.1, -0.8}),
                  rows({0.7674179064, 0.0484624518, -0.6393130280, 0.4780294780, 0.6212555089, 0.6209101472,
                        0.4272675686, -0.7821080382, 0.4535961214})),
            5.1e-11);
  EXPECT_LT(apart(rotation_matrix(RodriguesParameters{0.4, -0.6, 0.9}),
                  rows({0.5609756098, -0.7654784240, -0.3151969981, 0.5853658537, 0.6360225141, -0.5028142589,
                        0.5853658537, 0.0975609756, 0.8048780488})),
            5.1e-11);
}

// Mussio D.8: R' of section 4.1, whose parameters lack the factor 1/2.
TEST(RotationAngles, RodriguesWithoutTheHalfOfMussioD8) {
  const Matrix3d r = rotation_matrix(RodriguesParameters{2 * 0.4, -2 * 0.6, 2 * 0.9});
  EXPECT_LT(apart(r.transpose(), rows({-0.0042918455, 0.5665236052, 0.8240343348, -0.9785407725, 0.1673819742,
                                       -0.1201716738, -0.2060085837, -0.8068669528, 0.5536480687})),
            5.1e-11);
}

// Mussio D.6: a frontal photograph of a facade has X, Y, Z of the object where a level one has X, Z, -Y. (The text
// prints row 2 as 0, 1, 1: E9.)
TEST(RotationAngles, FrontalAxesOfMussioD6) {
  EXPECT_LT(apart(rotation_matrix(CardanAngles{kPi / 2, 0, 0}), rows({1, 0, 0, 0, 0, 1, 0, -1, 0})), 1e-15);
}

TEST(RotationAngles, EveryParametrisationThereAndBack) {
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    const Matrix3d r = rotation_by({random.normal(), random.normal(), random.normal()}).toRotationMatrix();
    EXPECT_LT(apart(rotation_matrix(cardan_angles(r)), r), 1e-13);
    EXPECT_LT(apart(rotation_matrix(euler_angles(r)), r), 1e-13);
    EXPECT_LT(apart(rotation_matrix(topographic_angles(r)), r), 1e-13);
    EXPECT_LT(apart(rotation_matrix(geodetic_angles(r)), r), 1e-13);
    EXPECT_LT(apart(rotation_matrix(unit_quaternion(r)), r), 1e-13);
    const auto rodrigues = rodrigues_parameters(r);
    ASSERT_TRUE(rodrigues);
    EXPECT_LT(apart(rotation_matrix(*rodrigues), r), 1e-10);
  }
}

TEST(RotationAngles, SingularAttitudesKeepTheMatrix) {
  for (const double phi : {kPi / 2, -kPi / 2}) {
    const Matrix3d r = rotation_matrix(CardanAngles{0.4, phi, 1.1});
    const CardanAngles back = cardan_angles(r);
    EXPECT_TRUE(back.is_singular);
    EXPECT_EQ(back.kappa_rad, 0);
    EXPECT_LT(apart(rotation_matrix(back), r), 1e-9);
  }
  for (const double nutation : {0.0, kPi}) {
    const Matrix3d r = rotation_matrix(EulerAngles{0.4, nutation, 1.1});
    const EulerAngles back = euler_angles(r);
    EXPECT_TRUE(back.is_singular);
    EXPECT_EQ(back.spin_rad, 0);
    EXPECT_LT(apart(rotation_matrix(back), r), 1e-9);
  }
  EXPECT_FALSE(rodrigues_parameters(rotation_matrix(CardanAngles{kPi, 0, 0})));
}

// Mussio 1.2.5: with x to the east the rows are east, north and up of the position.
TEST(RotationAngles, GeodeticRowsAreEastNorthUp) {
  const double latitude = 0.8, longitude = 0.16;
  const Matrix3d r = rotation_matrix(GeodeticAngles{latitude, longitude, kPi / 2});
  const Eigen::Vector3d east(-std::sin(longitude), std::cos(longitude), 0);
  const Eigen::Vector3d up(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                           std::sin(latitude));
  EXPECT_LT((r.row(0).transpose() - east).norm(), 1e-14);
  EXPECT_LT((r.row(1).transpose() - up.cross(east)).norm(), 1e-14);
  EXPECT_LT((r.row(2).transpose() - up).norm(), 1e-14);
}

// The view, against the z axis of the image, has the azimuth and the zenith angle of the instrument.
TEST(RotationAngles, TopographicAnglesAreThoseOfTheView) {
  const double azimuth = 1.0, zenith = 1.4;
  const Matrix3d r = rotation_matrix(TopographicAngles{azimuth, zenith, 0});
  const Eigen::Vector3d view = -r.row(2).transpose();
  EXPECT_NEAR(view.z(), std::cos(zenith), 1e-14);
  EXPECT_NEAR(std::atan2(view.x(), view.y()), azimuth, 1e-14);
  EXPECT_NEAR(r.row(0).z(), 0, 1e-14);  // x of the image is level
  EXPECT_GT(r.row(1).z(), 0);           // and y up
}

TEST(RotationAngles, CardanAnglesAreOmegaPhiKappaOfACamera) {
  const OmegaPhiKappa degrees = omega_phi_kappa(cam_from_world({12, -7, 101}));
  Matrix3d image_from_cam = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const CardanAngles angles = cardan_angles(image_from_cam * cam_from_world({12, -7, 101}).toRotationMatrix());
  EXPECT_NEAR(angles.omega_rad * 180 / kPi, degrees.omega_deg, 1e-12);
  EXPECT_NEAR(angles.phi_rad * 180 / kPi, degrees.phi_deg, 1e-12);
  EXPECT_NEAR(angles.kappa_rad * 180 / kPi, degrees.kappa_deg, 1e-12);
}

TEST(RotationAngles, SmallRodriguesParametersAreAnglesWithTheirSignTurned) {
  const Matrix3d r = rotation_matrix(CardanAngles{1e-4, -2e-4, 3e-4});
  const RodriguesParameters p = *rodrigues_parameters(r);
  EXPECT_NEAR(p.a, -1e-4, 1e-7);
  EXPECT_NEAR(p.b, 2e-4, 1e-7);
  EXPECT_NEAR(p.c, -3e-4, 1e-7);
}

TEST(RotationAngles, DerivativesAgreeWithDifferences) {
  const CardanAngles at{0.3, -0.4, 0.7};
  const RotationDerivatives d = derivatives(at);
  constexpr double kStep = 1e-6;
  const auto difference = [&](double CardanAngles::*angle) -> Matrix3d {
    CardanAngles before = at, after = at;
    before.*angle -= kStep;
    after.*angle += kStep;
    return (rotation_matrix(after) - rotation_matrix(before)) / (2 * kStep);
  };
  EXPECT_LT(apart(d.by_omega, difference(&CardanAngles::omega_rad)), 1e-9);
  EXPECT_LT(apart(d.by_phi, difference(&CardanAngles::phi_rad)), 1e-9);
  EXPECT_LT(apart(d.by_kappa, difference(&CardanAngles::kappa_rad)), 1e-9);
}

TEST(RotationAngles, AMatrixOfRoundedElementsBecomesARotation) {
  Matrix3d rounded = rotation_matrix(CardanAngles{0.3, -0.4, 0.7});
  rounded = (rounded * 1000).array().round() / 1000;
  EXPECT_GT(orthonormality_error(rounded), 1e-4);
  const auto r = rotation_nearest_to(rounded);
  ASSERT_TRUE(r);
  EXPECT_LT(orthonormality_error(*r), 1e-14);
  EXPECT_LT(apart(*r, rounded), 1e-3);
  EXPECT_FALSE(rotation_nearest_to(-Matrix3d::Identity()));
  EXPECT_FALSE(rotation_nearest_to(Matrix3d::Zero()));
}

}  // namespace
}  // namespace collinea
