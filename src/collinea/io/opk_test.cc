// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/opk.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <fstream>
#include <numbers>

#include "collinea/base/test_folder.h"
#include "collinea/block/world_frame.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

Rigid3 pose_at(const Eigen::Vector3d& centre, const OmegaPhiKappa& angles) {
  const Eigen::Quaterniond rotation = cam_from_world(angles);
  return {rotation, -(rotation * centre)};
}

Block block_with(const Rigid3& pose, bool on_map) {
  Block block;
  block.cameras[{0}] = ideal_camera(1000, 1500, 1000);
  block.images[{4}] = {.file = "DSC 0004.jpg", .camera = {0}};
  block.images[{5}] = {.file = "DSC_5.jpg", .camera = {0}};
  set_pose(block, {4}, pose);
  set_pose(block, {5}, pose);
  if (on_map) block.georeference = Georeference{"EPSG:32633", 48, 16.5, 300};
  return block;
}

Eigen::Vector3d radians(const OmegaPhiKappa& angles) {
  return kRadians * Eigen::Vector3d(angles.omega_deg, angles.phi_deg, angles.kappa_deg);
}

// A covariance with correlations everywhere: rotations of 1 mrad, positions of 5 cm.
Matrix6d covariance(std::uint64_t seed) {
  Random random(seed);
  Matrix6d root;
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = (i / 6 < 3 ? 1e-3 : 0.05) * random.normal() / 2;
  return root * root.transpose();
}

TEST(AnglesByRotation, AreTheNumericDerivatives) {
  for (const OmegaPhiKappa angles : {OmegaPhiKappa{0, 0, 0}, {3, -5, 120}, {-40, 62, -170}, {179, -20, 15}}) {
    const Eigen::Quaterniond rotation = cam_from_world(angles);
    const Eigen::Matrix3d derivative = angles_by_rotation(angles);
    constexpr double kStep = 1e-5;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d e = kStep * Eigen::Vector3d::Unit(axis);
      Eigen::Vector3d difference =
          radians(omega_phi_kappa(rotation * rotation_by(e))) - radians(omega_phi_kappa(rotation * rotation_by(-e)));
      for (int i = 0; i < 3; ++i) difference[i] = std::remainder(difference[i], 2 * std::numbers::pi);
      EXPECT_LT((derivative.col(axis) - difference / (2 * kStep)).norm(), 1e-8 * (1 + derivative.norm()));
    }
  }
}

// e' C^-1 e of six numbers is chi-squared: the mean of n is 6 with the standard deviation sqrt(12 / n). The tilts are
// small against the angles, so that the linear propagation holds.
TEST(ExteriorOrientations, CovariancesMatchTheErrorsOfTheAngles) {
  for (const bool on_map : {false, true}) {
    const Rigid3 truth = pose_at({120, -60, 80}, {12, -25, 70});
    const Matrix6d given = covariance(3);
    const Eigen::LLT<Matrix6d> root(given);
    const auto rows = exterior_orientations(block_with(truth, on_map), {{ImageId{4}, given}}).value();
    ASSERT_TRUE(rows[0].covariance);
    EXPECT_FALSE(rows[1].covariance);
    const Eigen::LLT<Matrix6d> weight(*rows[0].covariance);
    Random random(5);
    constexpr int kTrials = 400;
    double sum = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      Eigen::Matrix<double, 6, 1> noise;
      for (double& value : noise) value = random.normal();
      const Eigen::Matrix<double, 6, 1> error = root.matrixL() * noise;
      const Eigen::Quaterniond rotation = truth.rotation * rotation_by(error.head<3>());
      const Eigen::Vector3d centre = centre_of(truth) + error.tail<3>();
      const auto moved = exterior_orientations(block_with({rotation, -(rotation * centre)}, on_map)).value();
      Eigen::Matrix<double, 6, 1> difference;
      difference << moved[0].centre_in_map - rows[0].centre_in_map, radians(moved[0].angles) - radians(rows[0].angles);
      sum += difference.dot(weight.solve(difference)) / kTrials;
    }
    EXPECT_NEAR(sum, 6, 4 * std::sqrt(12.0 / kTrials)) << on_map;
  }
}

TEST(WriteOpk, SigmasStandBehindTheNumbersAndComeBack) {
  const TestFolder folder;
  const Block block = block_with(pose_at({1, 2, 3}, {1, 2, 3}), false);
  const std::map<ImageId, PoseCovariance> known{{ImageId{4}, covariance(8)}};
  ASSERT_TRUE(write_opk(folder / "a.opk", block, known));
  const auto expected = exterior_orientations(block, known).value();
  const auto rows = read_opk(folder / "a.opk");
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[0].file, "DSC 0004.jpg");
  ASSERT_TRUE((*rows)[0].covariance);
  EXPECT_FALSE((*rows)[1].covariance);
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(std::sqrt((*(*rows)[0].covariance)(i, i)), std::sqrt((*expected[0].covariance)(i, i)), 1e-5);
  EXPECT_NEAR((*rows)[0].angles.kappa_deg, 3, 1e-6);
  ASSERT_TRUE(write_opk(folder / "b.opk", block));
  EXPECT_FALSE(read_opk(folder / "b.opk").value()[0].covariance);
}

TEST(ReadOpk, SigmasThatAreMissingOrNegativeAreNamedWithTheLine) {
  const TestFolder folder;
  const std::string titles = "# image x y z o p k sigma_x_m\n";
  for (const char* row : {"a.jpg 1 2 3 4 5 6", "a.jpg 1 2 3 4 5 6 1 1 1 1 1 -1", "a.jpg 1 2 3 4 5 6 1 1 1 1 1 x",
                          "a.jpg 1 2 3 4 5 6 1 1 1 1 1 inf"}) {
    std::ofstream(folder / "c.opk") << titles << row << "\n";
    const auto rows = read_opk(folder / "c.opk");
    ASSERT_FALSE(rows) << row;
    EXPECT_NE(rows.error().message.find("c.opk: line 2: not an orientation"), std::string::npos)
        << rows.error().message;
  }
}

}  // namespace
}  // namespace collinea
