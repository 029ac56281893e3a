// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_calibration.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// The position on the film as cameras see it: y down.
Vector2d turned(const Vector2d& film_mm) { return {film_mm.x(), -film_mm.y()}; }

// The lens on a camera of focal length `focal` in the unit of the film [mm], with decentring along its own axes.
void set_lens(Camera& camera, const FilmCalibration& calibration, const Vector2d& decentring) {
  camera.model = BrownOfMeasured{};
  const double k0 = calibration.radial[0], f = calibration.principal_distance_mm / (1 + k0);
  const std::array<int, 3> params = {Camera::kK1, Camera::kK2, Camera::kK3};
  for (std::size_t i = 0; i < params.size(); ++i)
    camera.params[std::size_t(params[i])] = calibration.radial[i + 1] * std::pow(f, 2.0 * double(i + 1)) / (1 + k0);
  camera.params[Camera::kP1] = decentring.x() * f / (1 + k0);
  camera.params[Camera::kP2] = decentring.y() * f / (1 + k0);
}

}  // namespace

Vector2d corrected_mm(const FilmCalibration& calibration, const Vector2d& film_mm) {
  const Vector2d v = film_mm - calibration.symmetry_point_mm;
  const double r2 = v.squaredNorm();
  double radial = 0;
  for (std::size_t i = calibration.radial.size(); i-- > 0;) radial = radial * r2 + calibration.radial[i];
  const Vector2d p(calibration.decentring[0], calibration.decentring[1]);
  return film_mm - calibration.principal_point_mm + v * radial + r2 * p + 2 * v.dot(p) * v;
}

Vector2d distorted_mm(const FilmCalibration& calibration, const Vector2d& corrected) {
  Vector2d film = corrected + calibration.principal_point_mm;
  for (int i = 0; i < 50; ++i) {
    const Vector2d step = corrected - corrected_mm(calibration, film);
    film += step;
    if (step.norm() < 1e-10) break;
  }
  return film;
}

Vector2d film_image_size(const FilmCalibration& calibration) {
  if (calibration.image_size_mm) return *calibration.image_size_mm;
  Vector2d half = 0.49 * calibration.size_mm;
  // A mark lies on a ground of its own, which reaches about as far as the mark again.
  const double reach = 1.5 * calibration.mark_size_mm;
  for (const CalibratedMark& mark : calibration.marks) {
    const Vector2d inner = (mark.film_mm.cwiseAbs().array() - reach).max(0);
    if (!(inner.x() < half.x() && inner.y() < half.y())) continue;
    // The side that loses less gives way; a mark in a corner costs both.
    const double least = std::min(inner.x(), inner.y()), most = std::max(inner.x(), inner.y());
    for (int axis = 0; axis < 2; ++axis)
      if (inner[axis] == most || least > 0.8 * most) half[axis] = std::min(half[axis], inner[axis]);
  }
  return 2 * half;
}

std::optional<std::array<double, 4>> fit_radial(std::span<const double> radii_mm,
                                                std::span<const double> distances_mm) {
  if (radii_mm.empty() || radii_mm.size() != distances_mm.size()) return std::nullopt;
  const double largest = *std::max_element(radii_mm.begin(), radii_mm.end());
  const auto rows = Eigen::Index(radii_mm.size()), columns = std::min<Eigen::Index>(4, rows);
  if (!(largest > 0) || !(*std::min_element(radii_mm.begin(), radii_mm.end()) >= 0)) return std::nullopt;
  Eigen::MatrixXd design(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index k = 0; k < columns; ++k)
      design(i, k) = std::pow(radii_mm[std::size_t(i)] / largest, 2.0 * double(k) + 1);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
  if (qr.rank() < columns) return std::nullopt;
  const Eigen::VectorXd k =
      qr.solve(Eigen::Map<const Eigen::VectorXd>(distances_mm.data(), Eigen::Index(distances_mm.size())));
  if (!k.allFinite()) return std::nullopt;
  std::array<double, 4> out{};
  for (Eigen::Index i = 0; i < columns; ++i) out[std::size_t(i)] = k[i] / std::pow(largest, 2.0 * double(i) + 1);
  return out;
}

Camera film_camera(const FilmCalibration& calibration) {
  Camera camera = ideal_camera(calibration.principal_distance_mm / (1 + calibration.radial[0]), 0, 0);
  const Vector2d centre = turned(calibration.principal_point_mm);
  camera.params[Camera::kCx] = centre.x();
  camera.params[Camera::kCy] = centre.y();
  camera.name = calibration.camera;
  set_lens(camera, calibration, turned({calibration.decentring[0], calibration.decentring[1]}));
  return camera;
}

std::optional<ScanCamera> scan_camera(const FilmCalibration& calibration, const FilmTransformation& scan_from_film) {
  if (scan_from_film.model == FilmModel::kProjective || scan_from_film.is_mirrored) return std::nullopt;
  // pixel = centre + A q, q counted from the principal point with y down; A = U Q, U upper triangular, Q a rotation.
  Matrix2d a = scan_from_film.by_film(calibration.principal_point_mm);
  a.col(1) *= -1;
  const double length = a.row(1).norm();
  if (!(length > 0) || !(a.determinant() > 0)) return std::nullopt;
  Matrix2d rotation;
  rotation << a(1, 1) / length, -a(1, 0) / length, a(1, 0) / length, a(1, 1) / length;
  const Matrix2d upper = a * rotation.transpose();
  const double f = calibration.principal_distance_mm / (1 + calibration.radial[0]);
  ScanCamera scan{film_camera(calibration), std::atan2(rotation(1, 0), rotation(0, 0))};
  const Vector2d centre = scan_from_film.pixel_of(calibration.principal_point_mm);
  auto& params = scan.camera.params;
  params[Camera::kF] = upper(1, 1) * f;
  params[Camera::kCx] = centre.x();
  params[Camera::kCy] = centre.y();
  params[Camera::kB1] = (upper(0, 0) - upper(1, 1)) * f;
  params[Camera::kB2] = upper(0, 1) * f;
  set_lens(scan.camera, calibration, rotation * turned({calibration.decentring[0], calibration.decentring[1]}));
  return scan;
}

}  // namespace collinea
