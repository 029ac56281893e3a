// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/rotation_angles.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

using Eigen::Matrix3d;
constexpr double kPi = std::numbers::pi;
constexpr double kSingularSine = 1e-9;  // below it the rounding of the matrix decides on the angles

Matrix3d rx(double w) {
  const double c = std::cos(w), s = std::sin(w);
  Matrix3d m;
  m << 1, 0, 0, 0, c, s, 0, -s, c;
  return m;
}

Matrix3d ry(double w) {
  const double c = std::cos(w), s = std::sin(w);
  Matrix3d m;
  m << c, 0, -s, 0, 1, 0, s, 0, c;
  return m;
}

Matrix3d rz(double w) {
  const double c = std::cos(w), s = std::sin(w);
  Matrix3d m;
  m << c, s, 0, -s, c, 0, 0, 0, 1;
  return m;
}

double from_zero(double angle) {  // in [0, 2 pi)
  const double wrapped = std::fmod(angle, 2 * kPi);
  return wrapped < 0 ? wrapped + 2 * kPi : wrapped;
}

double around_zero(double angle) {  // in (-pi, pi]
  const double wrapped = from_zero(angle);
  return wrapped > kPi ? wrapped - 2 * kPi : wrapped;
}

}  // namespace

Matrix3d rotation_matrix(const CardanAngles& a) { return rz(a.kappa_rad) * ry(a.phi_rad) * rx(a.omega_rad); }

Matrix3d rotation_matrix(const EulerAngles& a) { return rz(a.spin_rad) * rx(a.nutation_rad) * rz(a.precession_rad); }

Matrix3d rotation_matrix(const TopographicAngles& a) {
  return rotation_matrix(EulerAngles{2 * kPi - a.azimuth_rad, kPi - a.zenith_rad, a.roll_rad});
}

Matrix3d rotation_matrix(const GeodeticAngles& a) {
  return rotation_matrix(EulerAngles{kPi / 2 + a.longitude_rad, kPi / 2 - a.latitude_rad, kPi / 2 - a.azimuth_rad});
}

Matrix3d rotation_matrix(const RodriguesParameters& p) {
  Matrix3d s;
  s << 0, p.c, -p.b, -p.c, 0, p.a, p.b, -p.a, 0;
  s /= 2;
  const Matrix3d sum = Matrix3d::Identity() + s;
  return (Matrix3d::Identity() - s) * sum.inverse();
}

Matrix3d rotation_matrix(const Eigen::Quaterniond& quaternion) { return quaternion.normalized().toRotationMatrix(); }

CardanAngles cardan_angles(const Matrix3d& r) {
  const double cosine = std::hypot(r(0, 0), r(1, 0));
  const double phi = std::atan2(r(2, 0), cosine);
  if (cosine < kSingularSine) return {std::atan2(r(1, 2), r(1, 1)), phi, 0, true};
  return {std::atan2(-r(2, 1), r(2, 2)), phi, std::atan2(-r(1, 0), r(0, 0))};
}

EulerAngles euler_angles(const Matrix3d& r) {
  const double sine = std::hypot(r(2, 0), r(2, 1));
  const double nutation = std::atan2(sine, r(2, 2));
  if (sine < kSingularSine) return {std::atan2(r(0, 1), r(0, 0)), nutation, 0, true};
  return {std::atan2(r(2, 0), -r(2, 1)), nutation, std::atan2(r(0, 2), r(1, 2))};
}

TopographicAngles topographic_angles(const Matrix3d& r) {
  const EulerAngles e = euler_angles(r);
  return {from_zero(-e.precession_rad), kPi - e.nutation_rad, e.spin_rad, e.is_singular};
}

GeodeticAngles geodetic_angles(const Matrix3d& r) {
  const EulerAngles e = euler_angles(r);
  return {kPi / 2 - e.nutation_rad, around_zero(e.precession_rad - kPi / 2), around_zero(kPi / 2 - e.spin_rad),
          e.is_singular};
}

// S = (I + R)^-1 (I - R), by the trace: R - R' = -4 S / n, n = 1 + |abc|^2 / 4 = 4 / (1 + trace).
std::optional<RodriguesParameters> rodrigues_parameters(const Matrix3d& r) {
  const double n = 1 + r.trace();
  if (!(n > 1e-12)) return std::nullopt;
  return RodriguesParameters{2 * (r(2, 1) - r(1, 2)) / n, 2 * (r(0, 2) - r(2, 0)) / n, 2 * (r(1, 0) - r(0, 1)) / n};
}

Eigen::Quaterniond unit_quaternion(const Matrix3d& rotation) {
  Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return q;
}

double orthonormality_error(const Matrix3d& matrix) {
  return (matrix * matrix.transpose() - Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

std::optional<Matrix3d> rotation_nearest_to(const Matrix3d& matrix) {
  if (!matrix.allFinite() || !(matrix.determinant() > 0)) return std::nullopt;
  const Eigen::JacobiSVD<Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[1] > 1e-12 * svd.singularValues()[0])) return std::nullopt;
  return svd.matrixU() * svd.matrixV().transpose();
}

RotationDerivatives derivatives(const CardanAngles& angles) {
  const Matrix3d r = rotation_matrix(angles);
  const double cf = std::cos(angles.phi_rad), sf = std::sin(angles.phi_rad);
  const double co = std::cos(angles.omega_rad), so = std::sin(angles.omega_rad);
  const double ck = std::cos(angles.kappa_rad), sk = std::sin(angles.kappa_rad);
  RotationDerivatives d;
  d.by_omega.col(0).setZero();
  d.by_omega.col(1) = -r.col(2);
  d.by_omega.col(2) = r.col(1);
  d.by_phi << -sf * ck, so * cf * ck, -co * cf * ck, sf * sk, -so * cf * sk, co * cf * sk, cf, so * sf, -co * sf;
  d.by_kappa.row(0) = r.row(1);
  d.by_kappa.row(1) = -r.row(0);
  d.by_kappa.row(2).setZero();
  return d;
}

}  // namespace collinea
