// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/rotation.h"

#include <gtest/gtest.h>

#include "collinea/geometry/similarity3.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

TEST(Rotation, VectorAndQuaternionAgreeBothWays) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const double size = i % 4 == 0 ? 1e-10 : 1.7;
    const Eigen::Vector3d v(random.normal() * size, random.normal() * size, random.normal() * size);
    const Eigen::Quaterniond q = rotation_by(v);
    EXPECT_LT(angle_between(rotation_by(rotation_vector(q)), q), 1e-12);
  }
  EXPECT_EQ(rotation_vector(rotation_by(Eigen::Vector3d::Zero())), Eigen::Vector3d::Zero());
}

TEST(Rotation, NadirImageToTheEastHasZeroAngles) {
  Eigen::Matrix3d rows;  // camera x = east, y (down in the image) = south, z = down
  rows << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const OmegaPhiKappa angles = omega_phi_kappa(Eigen::Quaterniond(rows));
  EXPECT_NEAR(angles.omega_deg, 0, 1e-12);
  EXPECT_NEAR(angles.phi_deg, 0, 1e-12);
  EXPECT_NEAR(angles.kappa_deg, 0, 1e-12);
}

TEST(Rotation, OmegaPhiKappaThereAndBack) {
  const OmegaPhiKappa angles{12, -7, 101};
  const OmegaPhiKappa back = omega_phi_kappa(cam_from_world(angles));
  EXPECT_NEAR(back.omega_deg, 12, 1e-10);
  EXPECT_NEAR(back.phi_deg, -7, 1e-10);
  EXPECT_NEAR(back.kappa_deg, 101, 1e-10);
}

// A camera that is turned about an axis of the ground: its angles change as stated.
TEST(Rotation, AnglesFollowATurnOfTheCamera) {
  constexpr double kStep = 1e-6, kDegrees = 57.295779513082323;
  for (const OmegaPhiKappa& angles :
       {OmegaPhiKappa{0, 0, 0}, OmegaPhiKappa{12, -7, 101}, OmegaPhiKappa{-95, 60, -30}}) {
    const Eigen::Matrix3d stated = angles_by_rotation_of_camera(angles);
    for (int axis = 0; axis < 3; ++axis) {
      const auto turned = [&](double by) {  // world_from_cam from the left
        const Eigen::Quaterniond turn = rotation_by(by * Eigen::Vector3d::Unit(axis));
        return omega_phi_kappa((turn * cam_from_world(angles).conjugate()).conjugate());
      };
      const OmegaPhiKappa before = turned(-kStep), after = turned(kStep);
      const Eigen::Vector3d change(after.omega_deg - before.omega_deg, after.phi_deg - before.phi_deg,
                                   after.kappa_deg - before.kappa_deg);
      EXPECT_LT((change / kDegrees / (2 * kStep) - stated.col(axis)).norm(), 1e-8) << axis;
    }
  }
}

// Published example: Mikhail, Bethel, McGlone use m = Rz(kappa) Ry(phi) Rx(omega) for image_from_ground with
// m(2,0) = sin(phi) (third row, first column), the transpose of ours.
TEST(Rotation, SineOfPhiStandsWhereTheTextbooksPutIt) {
  const Eigen::Quaterniond cam = cam_from_world({0, 30, 0});
  const Eigen::Vector3d optical_axis_in_world = cam.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR(optical_axis_in_world.x(), -0.5, 1e-12);
  EXPECT_NEAR(optical_axis_in_world.z(), -std::sqrt(0.75), 1e-12);
}

TEST(Align, FindsTheExactSimilarity) {
  Random random(2);
  const Similarity3 truth{2.5, rotation_by({0.3, -1.2, 2}), {10, -4, 7}};
  std::vector<Eigen::Vector3d> a, b;
  for (int i = 0; i < 7; ++i) {
    a.push_back({random.normal(), random.normal(), random.normal()});
    b.push_back(truth * a.back());
  }
  const auto found = align(a, b);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->scale, 2.5, 1e-12);
  EXPECT_LT(angle_between(found->rotation, truth.rotation), 1e-12);
  EXPECT_LT((found->translation - truth.translation).norm(), 1e-11);
  EXPECT_LT((inverse(*found) * b[3] - a[3]).norm(), 1e-12);
}

TEST(Align, PointsOnALineFixNoRotation) {
  std::vector<Eigen::Vector3d> a{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 0, 0}};
  EXPECT_FALSE(align(a, a));
}

TEST(Moved, ACameraSeesTheSameAfterItsWorldHasMoved) {
  const Similarity3 b_from_a{3, rotation_by({1, 0.2, 0.4}), {1, 2, 3}};
  const Rigid3 cam_from_a{rotation_by({0.1, 0.2, 0.3}), {0.5, 0.6, 4}};
  const Eigen::Vector3d point(0.3, 0.2, 2);
  const Eigen::Vector3d before = cam_from_a * point, after = moved(cam_from_a, b_from_a) * (b_from_a * point);
  EXPECT_LT((after - 3 * before).norm(), 1e-12);
}

}  // namespace
}  // namespace collinea
