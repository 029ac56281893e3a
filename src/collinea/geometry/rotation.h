// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

namespace collinea {

/// The rotation by the vector `axis * angle` [rad] (Rodrigues; the exponential map). Exact for the zero vector.
[[nodiscard]] Eigen::Quaterniond rotation_by(const Eigen::Vector3d& axis_times_angle_rad);

/// The inverse of rotation_by: axis times angle, angle in [0, pi] [rad].
[[nodiscard]] Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation);

/// The angle of the rotation between two attitudes, in [0, pi] [rad].
[[nodiscard]] double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// [v]x, so that skew(v) * w = v x w.
[[nodiscard]] Eigen::Matrix3d skew(const Eigen::Vector3d& v);

/// Photogrammetric angles of a camera [deg], for the border of the program (reports, files):
/// ground_from_image = Rx(omega) * Ry(phi) * Rz(kappa), with the image frame x right, y up, z backward, so that a nadir
/// image with its x axis to the east has all three zero.
struct OmegaPhiKappa {
  double omega_deg = 0, phi_deg = 0, kappa_deg = 0;
};
[[nodiscard]] OmegaPhiKappa omega_phi_kappa(const Eigen::Quaterniond& cam_from_world);
[[nodiscard]] Eigen::Quaterniond cam_from_world(const OmegaPhiKappa& angles);

/// The derivatives of omega, phi, kappa (rows) by small turns of the camera about x, y, z of the ground (columns),
/// right handed: ground_from_image becomes rotation_by(turn) * ground_from_image. Near a nadir image it is the unit
/// matrix; it has no bound where the camera looks along the horizon to the east or west (phi 90 degrees).
[[nodiscard]] Eigen::Matrix3d angles_by_rotation_of_camera(const OmegaPhiKappa& angles);

}  // namespace collinea
