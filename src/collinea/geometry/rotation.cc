// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/rotation.h"

#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

// Camera frame (y down, z forward) from image frame (y up, z backward); its own inverse.
const Eigen::Quaterniond kCamFromImage(0, 1, 0, 0);

Eigen::Quaterniond about(const Eigen::Vector3d& axis, double angle_deg) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_deg / kDegreesPerRadian, axis));
}

}  // namespace

Eigen::Quaterniond rotation_by(const Eigen::Vector3d& axis_times_angle_rad) {
  const double squared = axis_times_angle_rad.squaredNorm();
  Eigen::Quaterniond rotation;
  if (squared < 1e-16) {  // sin(x/2)/x = 1/2 - x^2/48, exact in double here
    rotation.w() = 1 - squared / 8;
    rotation.vec() = axis_times_angle_rad * (0.5 - squared / 48);
  } else {
    const double angle = std::sqrt(squared);
    rotation.w() = std::cos(angle / 2);
    rotation.vec() = axis_times_angle_rad * (std::sin(angle / 2) / angle);
  }
  return rotation.normalized();
}

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation) {
  const double sine = rotation.vec().norm();
  const double angle = 2 * std::atan2(sine, std::abs(rotation.w()));
  const double factor = sine < 1e-12 ? 2.0 : angle / sine;
  return (rotation.w() < 0 ? -factor : factor) * rotation.vec();
}

double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return rotation_vector(a * b.conjugate()).norm();
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

OmegaPhiKappa omega_phi_kappa(const Eigen::Quaterniond& cam_from_world) {
  // m = Rx(omega) Ry(phi) Rz(kappa), rows written out: m02 = sin(phi), m12 = -sin(omega) cos(phi), ...
  const Eigen::Matrix3d m = (cam_from_world.conjugate() * kCamFromImage).toRotationMatrix();
  return {std::atan2(-m(1, 2), m(2, 2)) * kDegreesPerRadian,
          std::atan2(m(0, 2), std::hypot(m(1, 2), m(2, 2))) * kDegreesPerRadian,
          std::atan2(-m(0, 1), m(0, 0)) * kDegreesPerRadian};
}

Eigen::Quaterniond cam_from_world(const OmegaPhiKappa& angles) {
  const Eigen::Quaterniond ground_from_image = about(Eigen::Vector3d::UnitX(), angles.omega_deg) *
                                               about(Eigen::Vector3d::UnitY(), angles.phi_deg) *
                                               about(Eigen::Vector3d::UnitZ(), angles.kappa_deg);
  return (kCamFromImage * ground_from_image.conjugate()).normalized();
}

Eigen::Matrix3d angles_by_rotation_of_camera(const OmegaPhiKappa& angles) {
  const double omega = angles.omega_deg / kDegreesPerRadian, phi = angles.phi_deg / kDegreesPerRadian;
  Eigen::Matrix3d axes;                                      // about which omega, phi and kappa turn, as columns
  axes << 1, 0, std::sin(phi),                               //
      0, std::cos(omega), -std::sin(omega) * std::cos(phi),  //
      0, std::sin(omega), std::cos(omega) * std::cos(phi);
  return axes.inverse();
}

}  // namespace collinea
