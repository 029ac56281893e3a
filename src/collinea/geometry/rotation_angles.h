// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace collinea {

// The rotation matrix of photogrammetry R = image_from_object, written by the parameters that the field uses (Mussio,
// Fotogrammetria Numerica, 1.2). Its rows are the axes of the image (x right, y up, z backward) in the object's frame.
// Angles in radians. With the elementary rotations of the frame
//     Rx(w) = [1 0 0; 0 c s; 0 -s c],   Ry(w) = [c 0 -s; 0 1 0; s 0 c],   Rz(w) = [c s 0; -s c 0; 0 0 1]
// Each has its singular attitudes, where one angle is free: extraction then sets one to zero and says so.

/// R = Rz(kappa) Ry(phi) Rx(omega): photogrammetry. phi in [-pi/2, pi/2]; singular at its ends (kappa becomes 0).
struct CardanAngles {
  double omega_rad = 0, phi_rad = 0, kappa_rad = 0;
  bool is_singular = false;
};
/// R = Rz(spin) Rx(nutation) Rz(precession): navigation. nutation in [0, pi]; singular at its ends (spin becomes 0).
struct EulerAngles {
  double precession_rad = 0, nutation_rad = 0, spin_rad = 0;
  bool is_singular = false;
};
/// Of an instrument that looks along its axis: azimuth clockwise from the y axis of the object, zenith angle from its z
/// axis, roll about the view. As Euler angles: 2 pi - azimuth, pi - zenith, roll.
struct TopographicAngles {
  double azimuth_rad = 0, zenith_rad = 0, roll_rad = 0;
  bool is_singular = false;
};
/// Of an image whose z axis is the upward normal at a latitude and longitude of a geocentric frame, and whose x axis
/// points along an azimuth (pi/2: to the east). As Euler angles: pi/2 + longitude, pi/2 - latitude, pi/2 - azimuth. A
/// geodetic latitude gives the normal of the ellipsoid, a geocentric one the direction from its centre.
struct GeodeticAngles {
  double latitude_rad = 0, longitude_rad = 0, azimuth_rad = 0;
  bool is_singular = false;
};
/// R = (I - S) (I + S)^-1, S = 1/2 [0 c -b; -c 0 a; b -a 0]: for small angles (a, b, c) = -(omega, phi, kappa).
struct RodriguesParameters {
  double a = 0, b = 0, c = 0;
};

[[nodiscard]] Eigen::Matrix3d rotation_matrix(const CardanAngles& angles);
[[nodiscard]] Eigen::Matrix3d rotation_matrix(const EulerAngles& angles);
[[nodiscard]] Eigen::Matrix3d rotation_matrix(const TopographicAngles& angles);
[[nodiscard]] Eigen::Matrix3d rotation_matrix(const GeodeticAngles& angles);
[[nodiscard]] Eigen::Matrix3d rotation_matrix(const RodriguesParameters& parameters);
/// R of the unit quaternion that turns vectors: R = q v q*. A quaternion of any length but zero.
[[nodiscard]] Eigen::Matrix3d rotation_matrix(const Eigen::Quaterniond& quaternion);

[[nodiscard]] CardanAngles cardan_angles(const Eigen::Matrix3d& rotation);
[[nodiscard]] EulerAngles euler_angles(const Eigen::Matrix3d& rotation);
[[nodiscard]] TopographicAngles topographic_angles(const Eigen::Matrix3d& rotation);  ///< azimuth in [0, 2 pi)
[[nodiscard]] GeodeticAngles geodetic_angles(const Eigen::Matrix3d& rotation);        ///< longitude in (-pi, pi]
/// Nothing of a rotation by pi, within 1e-12 of its trace.
[[nodiscard]] std::optional<RodriguesParameters> rodrigues_parameters(const Eigen::Matrix3d& rotation);
/// With w >= 0.
[[nodiscard]] Eigen::Quaterniond unit_quaternion(const Eigen::Matrix3d& rotation);

/// How far a matrix is from a rotation: the largest element of R R' - I.
[[nodiscard]] double orthonormality_error(const Eigen::Matrix3d& matrix);
/// The rotation nearest to a matrix in the sum of squares of the elements (singular value decomposition). Nothing when
/// the determinant is not positive, or the matrix has rank 1.
[[nodiscard]] std::optional<Eigen::Matrix3d> rotation_nearest_to(const Eigen::Matrix3d& matrix);

/// The derivatives of R's elements by omega, phi and kappa (Mussio 2.4.1).
struct RotationDerivatives {
  Eigen::Matrix3d by_omega, by_phi, by_kappa;
};
[[nodiscard]] RotationDerivatives derivatives(const CardanAngles& angles);

}  // namespace collinea
