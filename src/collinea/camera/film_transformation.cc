// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_transformation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/camera/internal/film_parameters.h"

namespace collinea {
namespace {

using namespace film;

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

// All eight parameters: those that a model lacks have the values that it gives them.
std::array<double, kParameters> complete(const FilmTransformation& t) {
  std::array<double, kParameters> all{};
  for (int i = 0; i < t.parameters.size(); ++i) all[std::size_t(i)] = t.parameters[i];
  if (t.model == FilmModel::kRigid) all[kScaleX] = t.scale_px_per_mm;
  if (t.model == FilmModel::kRigid || t.model == FilmModel::kSimilarity) all[kScaleY] = all[kScaleX];
  return all;
}

// The linear part without the rotation: [mx  my s; 0  my].
Matrix2d stretch(const std::array<double, kParameters>& p) {
  Matrix2d stretch;
  stretch << p[kScaleX], p[kScaleY] * p[kShear], 0, p[kScaleY];
  return stretch;
}

double divisor(const std::array<double, kParameters>& p, const Vector2d& q) {
  return 1 + p[kPerspectiveX] * q.x() + p[kPerspectiveY] * q.y();
}

}  // namespace

int parameter_count(FilmModel model) {
  constexpr std::array<int, 5> kCount = {3, 4, 5, 6, 8};
  return kCount[std::size_t(model)];
}

std::string_view film_parameter_name(int parameter) {
  constexpr std::array<std::string_view, kParameters> kNames = {"column",  "row",   "rotation",      "scale_x",
                                                                "scale_y", "shear", "perspective_x", "perspective_y"};
  return kNames[std::size_t(parameter)];
}

std::string_view film_parameter_unit(int parameter) {
  constexpr std::array<std::string_view, kParameters> kUnits = {"px",    "px", "rad",  "px/mm",
                                                                "px/mm", "1",  "1/mm", "1/mm"};
  return kUnits[std::size_t(parameter)];
}

Vector2d FilmTransformation::pixel_of(const Vector2d& film_mm) const {
  const auto p = complete(*this);
  const Vector2d q = turned(film_mm, is_mirrored);
  return Vector2d(p[kColumn], p[kRow]) + turned_by(p[kRotation]) * stretch(p) * q / divisor(p, q);
}

Matrix2d FilmTransformation::by_film(const Vector2d& film_mm) const {
  const auto p = complete(*this);
  const Vector2d q = turned(film_mm, is_mirrored);
  const double d = divisor(p, q);
  const Eigen::RowVector2d by_q(p[kPerspectiveX], p[kPerspectiveY]);
  Matrix2d by = turned_by(p[kRotation]) * (stretch(p) / d - stretch(p) * q * by_q / (d * d));
  if (!is_mirrored) by.col(1) *= -1;
  return by;
}

Eigen::Matrix<double, 2, Eigen::Dynamic> FilmTransformation::by_parameters(const Vector2d& film_mm) const {
  const auto p = complete(*this);
  const Vector2d q = turned(film_mm, is_mirrored), u = stretch(p) * q;
  const double d = divisor(p, q);
  const Matrix2d rotation = turned_by(p[kRotation]);
  Eigen::Matrix<double, 2, kParameters> by;
  by.col(kColumn) = Vector2d::UnitX();
  by.col(kRow) = Vector2d::UnitY();
  by.col(kRotation) = turned_by(p[kRotation] + std::acos(-1.0) / 2) * u / d;
  by.col(kScaleX) = rotation * (model == FilmModel::kSimilarity ? q : Vector2d(q.x(), 0)) / d;
  by.col(kScaleY) = rotation * Vector2d(p[kShear] * q.y(), q.y()) / d;
  by.col(kShear) = rotation * Vector2d(p[kScaleY] * q.y(), 0) / d;
  by.col(kPerspectiveX) = -rotation * u * (q.x() / (d * d));
  by.col(kPerspectiveY) = -rotation * u * (q.y() / (d * d));
  return by.leftCols(parameter_count(model));
}

std::optional<Vector2d> FilmTransformation::film_of(const Vector2d& pixel) const {
  Vector2d film = by_film(Vector2d::Zero()).inverse() * (pixel - pixel_of(Vector2d::Zero()));
  for (int round = 0; round < 50; ++round) {
    if (!(divisor(complete(*this), turned(film, is_mirrored)) > 0)) return std::nullopt;
    const Vector2d step = by_film(film).inverse() * (pixel - pixel_of(film));
    film += step;
    if (!film.allFinite()) return std::nullopt;
    if (step.norm() <= 1e-12 * (1 + film.norm())) return film;
  }
  return std::nullopt;
}

Position2 FilmTransformation::pixel_with_covariance(const Vector2d& film_mm) const {
  const auto by = by_parameters(film_mm);
  return {pixel_of(film_mm), by * covariance * by.transpose()};
}

std::optional<Position2> FilmTransformation::film_with_covariance(const Vector2d& pixel,
                                                                  const Matrix2d& pixel_covariance) const {
  const auto film = film_of(pixel);
  if (!film) return std::nullopt;
  const Matrix2d film_by_pixel = by_film(*film).inverse();
  const auto by = by_parameters(*film);
  const Matrix2d in_pixels = by * covariance * by.transpose() + pixel_covariance;
  return Position2{*film, film_by_pixel * in_pixels * film_by_pixel.transpose()};
}

FilmTransformation without_marks(const Vector2d& origin_pixel, double pixel_mm) {
  FilmTransformation t;
  t.model = FilmModel::kRigid;
  t.scale_px_per_mm = 1 / pixel_mm;
  t.parameters = Eigen::Vector3d(origin_pixel.x(), origin_pixel.y(), 0);
  t.covariance = Eigen::Matrix3d::Zero();
  return t;
}

}  // namespace collinea
