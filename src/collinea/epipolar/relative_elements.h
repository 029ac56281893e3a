// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/geometry/rigid3.h"

namespace collinea {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

/// The elements of a relative orientation as photogrammetry writes them, and what links them. They live in the frames
/// of photographs: x to the right, y up, z backwards, image points at (x, y, -c), R(object to image) = Rz(kappa)
/// Ry(phi) Rx(omega); inside the program cameras have y down and z forward (x, -y, -z). Angles in radians.
/// Sources: Mussio, Fotogrammetria Numerica, 2.1-2.2 (with the corrected conversion of 2.2.5); Kraus, Photogrammetry 1.

/// Dependent pair: the model has the axes of the first photograph, the second one moves. The base has the component
/// +1 or -1 along x: by and bz count in units of it.
struct DependentElements {
  double bx = 1;  ///< +1, or -1 where the second photograph stands on the left
  double by = 0, bz = 0, omega = 0, phi = 0, kappa = 0;

  [[nodiscard]] Vector5 values() const { return (Vector5() << by, bz, omega, phi, kappa).finished(); }
};

/// Independent pair (symmetric): the model has its x axis along the base, omega of the first photograph is zero.
struct SymmetricElements {
  double phi1 = 0, kappa1 = 0, omega2 = 0, phi2 = 0, kappa2 = 0;

  [[nodiscard]] Vector5 values() const { return (Vector5() << phi1, kappa1, omega2, phi2, kappa2).finished(); }
};

/// The base in the first camera: the direction to the second projection centre, of unit length.
[[nodiscard]] Eigen::Vector3d base_in_first(const Rigid3& second_from_first);
/// Two directions across a unit vector, and across each other; always the same ones for the same vector.
[[nodiscard]] Eigen::Matrix<double, 3, 2> tangents_of(const Eigen::Vector3d& unit);

/// A motion after a small change of its five degrees of freedom: [turn of the second camera (rad, in its own frame),
/// shift of the base along tangents_of(base_in_first)]. Covariances of relative orientations are of this change.
[[nodiscard]] Rigid3 changed(const Rigid3& second_from_first, const Vector5& change);

/// Nothing where the base has no component along x (below 1e-6 of its length).
[[nodiscard]] std::optional<DependentElements> dependent_elements(const Rigid3& second_from_first);
/// Along the first camera's axis (phi1 = +-90 degrees) kappa1 is taken to be 0.
[[nodiscard]] SymmetricElements symmetric_elements(const Rigid3& second_from_first);
/// The translation has unit length.
[[nodiscard]] Rigid3 motion_of(const DependentElements& elements);
[[nodiscard]] Rigid3 motion_of(const SymmetricElements& elements);

/// Derivatives of the elements by the change of the motion: covariance of the elements = J C J'. Without bound where
/// the elements are singular (base across x; phi of +-90 degrees).
[[nodiscard]] Matrix5 dependent_by_change(const Rigid3& second_from_first);
[[nodiscard]] Matrix5 symmetric_by_change(const Rigid3& second_from_first);

/// Derivatives of the exterior orientation of the second image in the model, [rotation of the camera about the axes of
/// the model (rad), projection centre (unit of the base)], by [changed(), length of the base]. The axes of the model
/// are those of the first photograph (x right, y up, z backwards), where its projection centre is the origin.
[[nodiscard]] Eigen::Matrix<double, 6, 6> pose_by_change(const Rigid3& second_from_first, double base);

/// Elements of one kind with the covariance of their values().
struct DependentWithCovariance {
  DependentElements elements;
  Matrix5 covariance;
};
struct SymmetricWithCovariance {
  SymmetricElements elements;
  Matrix5 covariance;
};
/// The conversions keep all that is known: there and back is the identity. Nothing as dependent_elements().
[[nodiscard]] SymmetricWithCovariance symmetric_of(const DependentWithCovariance& dependent);
[[nodiscard]] std::optional<DependentWithCovariance> dependent_of(const SymmetricWithCovariance& symmetric);

/// The coplanarity condition b . (q1 x q2) = 0 of two rays and the base, in its three forms: in the model with both
/// attitudes (object to image), in the first photograph and in the second. One number, whichever it is.
/// Rays are (x, y, -c) in their photographs.
[[nodiscard]] double coplanarity_in_model(const Eigen::Vector3d& base, const Eigen::Matrix3d& image1_from_model,
                                          const Eigen::Matrix3d& image2_from_model, const Eigen::Vector3d& ray1,
                                          const Eigen::Vector3d& ray2);
[[nodiscard]] double coplanarity_in_first(const Eigen::Vector3d& base_in_first,
                                          const Eigen::Matrix3d& second_from_first, const Eigen::Vector3d& ray1,
                                          const Eigen::Vector3d& ray2);
[[nodiscard]] double coplanarity_in_second(const Eigen::Vector3d& base_in_second,
                                           const Eigen::Matrix3d& first_from_second, const Eigen::Vector3d& ray1,
                                           const Eigen::Vector3d& ray2);

/// The condition of a pair, with its derivatives by values() of the elements and by x1, y1, x2, y2.
struct Coplanarity {
  double value;
  Vector5 by_elements;
  Eigen::Vector4d by_coordinates;
};
/// bx (y1 zeta2 + c eta2) - by (x1 zeta2 + c xi2) + bz (x1 eta2 - y1 xi2), (xi, eta, zeta) the second ray in the model
/// (Mussio 2.2.1-2.2.2, the derivatives as corrected there: E12).
[[nodiscard]] Coplanarity coplanarity(const DependentElements& elements, const Eigen::Vector3d& ray1,
                                      const Eigen::Vector3d& ray2);
/// eta1 zeta2 - zeta1 eta2 (Mussio 2.2.3-2.2.4, the derivatives as corrected there: E13-E17).
[[nodiscard]] Coplanarity coplanarity(const SymmetricElements& elements, const Eigen::Vector3d& ray1,
                                      const Eigen::Vector3d& ray2);

}  // namespace collinea
