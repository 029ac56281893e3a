// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

#include "collinea/geometry/rigid3.h"
#include "collinea/geometry/rotation.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// A pose as people read it: X, Y, Z, omega, phi, kappa, without standard deviations.
[[nodiscard]] inline std::vector<Estimate> estimates_of_pose(const Rigid3& cam_from_world) {
  const Eigen::Vector3d centre = centre_of(cam_from_world);
  const OmegaPhiKappa angles = omega_phi_kappa(cam_from_world.rotation);
  return {{"X", "m", centre.x()},         {"Y", "m", centre.y()},
          {"Z", "m", centre.z()},         {"omega", "deg", angles.omega_deg},
          {"phi", "deg", angles.phi_deg}, {"kappa", "deg", angles.kappa_deg}};
}

/// The covariance of these, from that of [rotation about the axes of the world (rad), centre (m)].
[[nodiscard]] inline Eigen::Matrix<double, 6, 6> covariance_of_estimates(
    const Rigid3& cam_from_world, const Eigen::Matrix<double, 6, 6>& covariance) {
  Eigen::Matrix<double, 6, 6> by = Eigen::Matrix<double, 6, 6>::Zero();
  by.topRightCorner<3, 3>().setIdentity();
  by.bottomLeftCorner<3, 3>() =
      180 / std::numbers::pi * angles_by_rotation_of_camera(omega_phi_kappa(cam_from_world.rotation));
  return by * covariance * by.transpose();
}
/// And back.
[[nodiscard]] inline Eigen::Matrix<double, 6, 6> covariance_of_pose(const Rigid3& cam_from_world,
                                                                    const Eigen::Matrix<double, 6, 6>& of_estimates) {
  Eigen::Matrix<double, 6, 6> by = Eigen::Matrix<double, 6, 6>::Zero();
  by.bottomLeftCorner<3, 3>().setIdentity();
  by.topRightCorner<3, 3>() =
      angles_by_rotation_of_camera(omega_phi_kappa(cam_from_world.rotation)).inverse() * std::numbers::pi / 180;
  return by * of_estimates * by.transpose();
}

/// Fills in the standard deviations.
inline void add_sigmas(std::vector<Estimate>& estimates, const Eigen::MatrixXd& covariance) {
  for (std::size_t i = 0; i < estimates.size(); ++i)
    estimates[i].sigma = std::sqrt(covariance(Eigen::Index(i), Eigen::Index(i)));
}

}  // namespace collinea
