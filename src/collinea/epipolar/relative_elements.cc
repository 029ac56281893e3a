// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/relative_elements.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

constexpr double kLeastAlongX = 1e-6;
constexpr double kDegree = std::numbers::pi / 180;

// From the frame of a camera (y down, z forward) to that of a photograph (y up, z backwards), and back.
const Eigen::Quaterniond kTurned(0, 1, 0, 0);

Eigen::Vector3d turned(const Eigen::Vector3d& v) { return {v.x(), -v.y(), -v.z()}; }

// R(object to image) of photographs.
Eigen::Matrix3d attitude(double omega, double phi, double kappa) {
  using Eigen::AngleAxisd;
  using Eigen::Vector3d;
  return (AngleAxisd(omega, Vector3d::UnitX()) * AngleAxisd(phi, Vector3d::UnitY()) *
          AngleAxisd(kappa, Vector3d::UnitZ()))
      .toRotationMatrix()
      .transpose();
}

// The angles of image_from_model, both with the axes of photographs.
OmegaPhiKappa angles_of(const Eigen::Quaterniond& image_from_model) {
  return omega_phi_kappa((kTurned * image_from_model).normalized());
}

// The rotation of the second photograph against the first.
Eigen::Quaterniond image_rotation(const Rigid3& second_from_first) {
  return kTurned * second_from_first.rotation * kTurned.conjugate();
}

Rigid3 motion(const Eigen::Matrix3d& second_from_first, const Eigen::Vector3d& base) {
  Rigid3 out;
  out.rotation = (kTurned.conjugate() * Eigen::Quaterniond(second_from_first) * kTurned).normalized();
  out.translation = -(out.rotation * turned(base.normalized()));
  return out;
}

// Derivatives of R' q by omega, phi, kappa (columns), R' = Rx Ry Rz: each angle turns about an axis of the model.
Eigen::Matrix3d ray_by_angles(double omega, double phi, const Eigen::Vector3d& ray_in_model) {
  const Eigen::Vector3d about_phi(0, std::cos(omega), std::sin(omega)),
      about_kappa(std::sin(phi), -std::sin(omega) * std::cos(phi), std::cos(omega) * std::cos(phi));
  Eigen::Matrix3d by;
  by.col(0) = Eigen::Vector3d::UnitX().cross(ray_in_model);
  by.col(1) = about_phi.cross(ray_in_model);
  by.col(2) = about_kappa.cross(ray_in_model);
  return by;
}

// Derivatives of the components of the base over its x component, by the tangents.
Eigen::Matrix2d ratios_by_tangents(const Eigen::Vector3d& base, const Eigen::Matrix<double, 3, 2>& tangents) {
  Eigen::Matrix2d by;
  for (int k = 0; k < 2; ++k)
    for (int axis = 0; axis < 2; ++axis)
      by(axis, k) = (tangents(axis + 1, k) - base(axis + 1) / base.x() * tangents(0, k)) / std::abs(base.x());
  return by;
}

}  // namespace

Eigen::Vector3d base_in_first(const Rigid3& second_from_first) { return centre_of(second_from_first).normalized(); }

Eigen::Matrix<double, 3, 2> tangents_of(const Eigen::Vector3d& unit) {
  Eigen::Index least = 0;
  unit.cwiseAbs().minCoeff(&least);
  Eigen::Matrix<double, 3, 2> tangents;
  tangents.col(0) = unit.cross(Eigen::Vector3d::Unit(least)).normalized();
  tangents.col(1) = unit.cross(tangents.col(0));
  return tangents;
}

Rigid3 changed(const Rigid3& second_from_first, const Vector5& change) {
  const Eigen::Vector3d base = base_in_first(second_from_first);
  Rigid3 out;
  out.rotation = (rotation_by(change.head<3>()) * second_from_first.rotation).normalized();
  out.translation = -(out.rotation * (base + tangents_of(base) * change.tail<2>()).normalized());
  return out;
}

std::optional<DependentElements> dependent_elements(const Rigid3& second_from_first) {
  const Eigen::Vector3d base = turned(base_in_first(second_from_first));
  const double along = std::abs(base.x());
  if (!(along > kLeastAlongX)) return std::nullopt;
  const OmegaPhiKappa angles = angles_of(image_rotation(second_from_first));
  return DependentElements{base.x() > 0 ? 1.0 : -1.0,  base.y() / along,         base.z() / along,
                           angles.omega_deg * kDegree, angles.phi_deg * kDegree, angles.kappa_deg * kDegree};
}

SymmetricElements symmetric_elements(const Rigid3& second_from_first) {
  const Eigen::Vector3d base = turned(base_in_first(second_from_first));
  SymmetricElements out;
  const double across = std::hypot(base.x(), base.y());
  out.phi1 = std::atan2(base.z(), across);
  out.kappa1 = across > kLeastAlongX ? std::atan2(-base.y(), base.x()) : 0;
  const Eigen::Quaterniond first_from_model(attitude(0, out.phi1, out.kappa1));
  const OmegaPhiKappa angles = angles_of((image_rotation(second_from_first) * first_from_model).normalized());
  out.omega2 = angles.omega_deg * kDegree;
  out.phi2 = angles.phi_deg * kDegree;
  out.kappa2 = angles.kappa_deg * kDegree;
  return out;
}

Rigid3 motion_of(const DependentElements& elements) {
  return motion(attitude(elements.omega, elements.phi, elements.kappa), {elements.bx, elements.by, elements.bz});
}

Rigid3 motion_of(const SymmetricElements& elements) {
  const Eigen::Matrix3d first_from_model = attitude(0, elements.phi1, elements.kappa1),
                        second_from_model = attitude(elements.omega2, elements.phi2, elements.kappa2);
  return motion(second_from_model * first_from_model.transpose(), first_from_model.col(0));
}

Matrix5 dependent_by_change(const Rigid3& second_from_first) {
  const Eigen::Vector3d base = base_in_first(second_from_first);
  const Eigen::Quaterniond second = image_rotation(second_from_first);
  Matrix5 by = Matrix5::Zero();
  by.block<2, 2>(0, 3) = ratios_by_tangents(base, tangents_of(base));
  by.block<2, 2>(0, 3) *= -1;  // y and z of photographs point the other way
  // A turn d of the second camera turns the photograph, seen from the model, by -R' d.
  const Eigen::Matrix3d turn = -(second.conjugate() * kTurned).toRotationMatrix();
  by.block<3, 3>(2, 0) = angles_by_rotation_of_camera(angles_of(second)) * turn;
  return by;
}

Matrix5 symmetric_by_change(const Rigid3& second_from_first) {
  const Eigen::Vector3d base = turned(base_in_first(second_from_first));
  Eigen::Matrix<double, 3, 2> tangents = tangents_of(base_in_first(second_from_first));
  tangents.bottomRows<2>() *= -1;
  const SymmetricElements elements = symmetric_elements(second_from_first);
  const Eigen::Matrix3d model_from_first = attitude(0, elements.phi1, elements.kappa1).transpose();
  const Eigen::Quaterniond second = image_rotation(second_from_first);
  const double across2 = base.x() * base.x() + base.y() * base.y(), across = std::sqrt(across2);

  Matrix5 by = Matrix5::Zero();
  by.block<1, 2>(0, 3) = tangents.row(2) / across;
  by.block<1, 2>(1, 3) = (base.y() * tangents.row(0) - base.x() * tangents.row(1)) / across2;
  // How the second photograph turns against the model: by its own turn, and by that of the model with the base.
  Eigen::Matrix<double, 3, 5> turn = Eigen::Matrix<double, 3, 5>::Zero();
  turn.leftCols<3>() = -model_from_first * (second.conjugate() * kTurned).toRotationMatrix();
  const Eigen::Vector3d about_kappa(std::sin(elements.phi1), 0, std::cos(elements.phi1));
  turn.rightCols<2>() = Eigen::Vector3d::UnitY() * by.block<1, 2>(0, 3) + about_kappa * by.block<1, 2>(1, 3);
  const OmegaPhiKappa angles{elements.omega2 / kDegree, elements.phi2 / kDegree, elements.kappa2 / kDegree};
  by.bottomRows<3>() = angles_by_rotation_of_camera(angles) * turn;
  return by;
}

Eigen::Matrix<double, 6, 6> pose_by_change(const Rigid3& second_from_first, double base) {
  const Eigen::Vector3d unit = base_in_first(second_from_first);
  Eigen::Matrix<double, 6, 6> by = Eigen::Matrix<double, 6, 6>::Zero();
  // R <- exp(d) R is exp(-R' d) of the attitude R' of the camera.
  by.topLeftCorner<3, 3>() = -(kTurned * second_from_first.rotation.conjugate()).toRotationMatrix();
  by.block<3, 2>(3, 3) = base * kTurned.toRotationMatrix() * tangents_of(unit);
  by.block<3, 1>(3, 5) = turned(unit);
  return by;
}

SymmetricWithCovariance symmetric_of(const DependentWithCovariance& dependent) {
  const Rigid3 motion = motion_of(dependent.elements);
  const Matrix5 by = symmetric_by_change(motion) * dependent_by_change(motion).inverse();
  return {symmetric_elements(motion), by * dependent.covariance * by.transpose()};
}

std::optional<DependentWithCovariance> dependent_of(const SymmetricWithCovariance& symmetric) {
  const Rigid3 motion = motion_of(symmetric.elements);
  const auto elements = dependent_elements(motion);
  if (!elements) return std::nullopt;
  const Matrix5 by = dependent_by_change(motion) * symmetric_by_change(motion).inverse();
  return DependentWithCovariance{*elements, by * symmetric.covariance * by.transpose()};
}

double coplanarity_in_model(const Eigen::Vector3d& base, const Eigen::Matrix3d& image1_from_model,
                            const Eigen::Matrix3d& image2_from_model, const Eigen::Vector3d& ray1,
                            const Eigen::Vector3d& ray2) {
  return base.dot((image1_from_model.transpose() * ray1).cross(image2_from_model.transpose() * ray2));
}

double coplanarity_in_first(const Eigen::Vector3d& base_in_first, const Eigen::Matrix3d& second_from_first,
                            const Eigen::Vector3d& ray1, const Eigen::Vector3d& ray2) {
  return base_in_first.dot(ray1.cross(second_from_first.transpose() * ray2));
}

double coplanarity_in_second(const Eigen::Vector3d& base_in_second, const Eigen::Matrix3d& first_from_second,
                             const Eigen::Vector3d& ray1, const Eigen::Vector3d& ray2) {
  return base_in_second.dot((first_from_second.transpose() * ray1).cross(ray2));
}

Coplanarity coplanarity(const DependentElements& elements, const Eigen::Vector3d& ray1, const Eigen::Vector3d& ray2) {
  const Eigen::Vector3d base(elements.bx, elements.by, elements.bz);
  const Eigen::Matrix3d second = attitude(elements.omega, elements.phi, elements.kappa);
  const Eigen::Vector3d in_model = second.transpose() * ray2, normal = ray1.cross(in_model);
  const Eigen::Vector3d across = base.cross(ray1);
  Coplanarity out{};
  out.value = base.dot(normal);
  out.by_elements << normal.y(), normal.z(), ray_by_angles(elements.omega, elements.phi, in_model).transpose() * across;
  out.by_coordinates << in_model.cross(base).head<2>(), (second * across).head<2>();
  return out;
}

Coplanarity coplanarity(const SymmetricElements& elements, const Eigen::Vector3d& ray1, const Eigen::Vector3d& ray2) {
  const Eigen::Vector3d base = Eigen::Vector3d::UnitX();
  const Eigen::Matrix3d first = attitude(0, elements.phi1, elements.kappa1),
                        second = attitude(elements.omega2, elements.phi2, elements.kappa2);
  const Eigen::Vector3d one = first.transpose() * ray1, two = second.transpose() * ray2;
  Coplanarity out{};
  out.value = one.y() * two.z() - one.z() * two.y();
  const Eigen::Vector3d by_one = two.cross(base), by_two = base.cross(one);
  out.by_elements << ray_by_angles(0, elements.phi1, one).rightCols<2>().transpose() * by_one,
      ray_by_angles(elements.omega2, elements.phi2, two).transpose() * by_two;
  out.by_coordinates << (first * by_one).head<2>(), (second * by_two).head<2>();
  return out;
}

}  // namespace collinea
