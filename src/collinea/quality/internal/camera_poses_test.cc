// SPDX-License-Identifier: Apache-2.0
// Correlations of the parameters of cameras with poses.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

const Run kRun;

// Of 300 blocks over gentle ground with positions good to 2 cm: what f, in error, has in common with the height of the
// image that is named, with its rotation about north and with its phi, is what is reported, to four deviations (1 -
// rho^2) / sqrt(n).
TEST(CameraPoses, ErrorsGoTogetherAsStated) {
  constexpr int kBlocks = 300;
  const Block truth = testing::test_block({.rows = 2, .columns = 3, .points = 60, .relief_m = 3, .tilt_rad = 0.03});
  const double f = truth.cameras.begin()->second.params[Camera::kF];
  struct Pair {
    int of_pose;
    ImageId image{};
    double stated = 0, both = 0, own = 0, other = 0;
  };
  std::array<Pair, 3> pairs{{{5}, {1}, {7}}};
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    AdjustScope scope;
    const Block block = testing::measured_anew(truth, scope, seed);
    ExamineOptions options = testing::examined(Calibration::kFocal);
    const auto adjusted = examine(block, scope, options, kRun);
    ASSERT_TRUE(adjusted && !adjusted->undetermined);
    ASSERT_EQ(adjusted->camera_pose_correlations.size(), 9u);
    for (Pair& pair : pairs) {
      const CameraPoseCorrelation& one = adjusted->camera_pose_correlations[static_cast<std::size_t>(pair.of_pose)];
      ASSERT_EQ(one.of_pose, pair.of_pose);
      if (seed == 1) pair.image = one.image;
      ASSERT_EQ(one.image, pair.image) << seed;  // the geometry stays
      const Rigid3 &pose = adjusted->cam_from_world.at(pair.image), &exact = pose_of(truth, pair.image);
      const double rotation = rotation_vector(pose.rotation.conjugate() * exact.rotation).y();
      const double height = (centre_of(exact) - centre_of(pose)).z();
      const double phi = omega_phi_kappa(exact.rotation).phi_deg - omega_phi_kappa(pose.rotation).phi_deg;
      const double a = f - adjusted->cameras.begin()->second.params[Camera::kF], b = pair.of_pose == 5   ? height
                                                                                     : pair.of_pose == 7 ? phi
                                                                                                         : rotation;
      pair.stated += one.correlation / kBlocks;
      pair.both += a * b;
      pair.own += a * a;
      pair.other += b * b;
    }
  }
  for (const Pair& pair : pairs) {
    const double bound = 4 * (1 - pair.stated * pair.stated) / std::sqrt(kBlocks);
    EXPECT_NEAR(pair.both / std::sqrt(pair.own * pair.other), pair.stated, bound) << pair.of_pose;
    EXPECT_GT(std::abs(pair.stated), 2 * bound) << pair.of_pose;  // neither none nor the opposite would pass
  }
}

// The error of a pose, true rotation = rotation * rotation_by(e), is one of omega, phi and kappa with the other sign.
TEST(CameraPoses, AnglesFollowTheErrorOfAPoseAsStated) {
  constexpr double kStep = 1e-6;
  const auto radians = [](const OmegaPhiKappa& angles) -> Eigen::Vector3d {
    return Eigen::Vector3d(angles.omega_deg, angles.phi_deg, angles.kappa_deg) * std::numbers::pi / 180;
  };
  for (const OmegaPhiKappa& angles : {OmegaPhiKappa{0, 0, 0}, OmegaPhiKappa{5, -20, 130}, OmegaPhiKappa{80, 10, -40}}) {
    const Eigen::Quaterniond rotation = cam_from_world(angles);
    const Matrix6d stated = angles_by_rotation(rotation);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d e = kStep * Eigen::Vector3d::Unit(axis);
      const Eigen::Vector3d change =
          radians(omega_phi_kappa(rotation * rotation_by(e))) - radians(omega_phi_kappa(rotation * rotation_by(-e)));
      EXPECT_LT((change / (2 * kStep) - stated.block<3, 1>(0, axis)).norm(), 1e-8) << axis;
    }
    if (angles.omega_deg == 0) EXPECT_LT((stated.topLeftCorner<3, 3>() + Eigen::Matrix3d::Identity()).norm(), 1e-12);
  }
}

// Level ground, camera looking down: the focal length goes with the heights.
TEST(CameraPoses, LevelGroundTiesTheFocalLengthToTheHeight) {
  const Block block =
      testing::test_block({.points = 150, .relief_m = 0.5, .sigma_px = 0.5, .control = 9, .tilt_rad = 0.01});
  ExamineOptions options = testing::examined(Calibration::kBrown);
  const auto adjusted = examine(block, {}, options, kRun);
  ASSERT_TRUE(adjusted && !adjusted->undetermined);
  EXPECT_EQ(adjusted->camera_pose_correlations.size(), 9 * 8u);
  int with_height = 0;
  for (const CameraPoseCorrelation& one : adjusted->camera_pose_correlations) {
    if (one.param != Camera::kF || one.of_pose != 5) continue;
    EXPECT_GT(std::abs(one.correlation), 0.9);
    ++with_height;
  }
  EXPECT_EQ(with_height, 1);
}

// New measurements of a block that nothing fixes; the focal length is known to 50 px beforehand.
Block free_block_measured(Block block, AdjustScope& scope, std::uint64_t seed) {
  block = testing::measured_anew(std::move(block), scope, seed);
  for (auto& [id, image] : block.images) image.position.reset();
  return block;
}

// The motion of the whole that fits the errors of the tie points best: shift, turns, log scale about the origin.
Eigen::Matrix<double, 7, 1> motion_of_errors(const Examined& adjusted, const Block& truth) {
  Eigen::Matrix<double, 7, 7> normals = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> right = Eigen::Matrix<double, 7, 1>::Zero();
  for (const auto& [id, position] : adjusted.points) {
    Eigen::Matrix<double, 3, 7> g;
    g << Eigen::Matrix3d::Identity(), -skew(position), position;
    normals += g.transpose() * g;
    right += g.transpose() * (truth.points.at(id).position_in_world - position);
  }
  return normals.inverse() * right;
}

// In a free network they are of the datum of all tie points: once the motion of these is taken off, errors of 300
// blocks, in their standard deviations, go together as stated.
TEST(CameraPoses, OfAFreeNetworkErrorsGoTogetherAsStatedInTheDatumOfItsTiePoints) {
  constexpr int kBlocks = 300;
  const Block truth = testing::test_block({.rows = 2, .columns = 3, .points = 60, .relief_m = 3, .tilt_rad = 0.03});
  const double f = truth.cameras.begin()->second.params[Camera::kF];
  std::array<double, 6> stated{}, both{};
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    AdjustScope scope;
    const Block block = free_block_measured(truth, scope, seed);
    const auto adjusted = examine(block, scope, testing::examined(Calibration::kFocal), kRun);
    ASSERT_TRUE(adjusted && !adjusted->undetermined);
    ASSERT_EQ(adjusted->rank_defect, 7);
    ASSERT_EQ(adjusted->camera_pose_correlations.size(), 9u);
    const Eigen::Matrix<double, 7, 1> whole = motion_of_errors(*adjusted, truth);
    const double variance = std::pow(sigma_scale(*adjusted), 2);
    const double a = (f - adjusted->cameras.begin()->second.params[Camera::kF]) /
                     std::sqrt(variance * adjusted->camera_covariance.begin()->second(Camera::kF, Camera::kF));
    for (std::size_t k = 0; k < 6; ++k) {
      const CameraPoseCorrelation& one = adjusted->camera_pose_correlations[k];  // of the image where it is strongest
      const Rigid3 &pose = adjusted->cam_from_world.at(one.image), &exact = pose_of(truth, one.image);
      const Eigen::Vector3d centre = centre_of(pose);
      Eigen::Matrix<double, 6, 1> error;
      error << rotation_vector(pose.rotation.conjugate() * exact.rotation) + whole.segment<3>(3),
          centre_of(exact) - centre - whole.head<3>() - whole.segment<3>(3).cross(centre) - whole[6] * centre;
      stated[k] += one.correlation / kBlocks;
      const auto i = static_cast<Eigen::Index>(k);
      both[k] += a * error[i] / std::sqrt(variance * adjusted->pose_covariance.at(one.image)(i, i)) / kBlocks;
    }
  }
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_NEAR(both[k], stated[k], 4 * std::sqrt((1 + stated[k] * stated[k]) / kBlocks)) << k;
  EXPECT_GT(std::abs(stated[5]), 0.5);  // over gentle ground f goes with the heights of the images
}

}  // namespace
}  // namespace collinea
