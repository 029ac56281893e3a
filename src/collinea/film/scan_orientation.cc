// SPDX-License-Identifier: Apache-2.0
#include "collinea/film/scan_orientation.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace collinea {

double ScanOrientation::pixel_mm() const {
  return 1 / std::sqrt(std::abs(scan_from_film().by_film(Eigen::Vector2d::Zero()).determinant()));
}

double ScanOrientation::rms_mm() const {
  double squares = 0;
  int count = 0;
  for (const FilmMarkResidual& mark : choice.fit.marks) {
    if (!mark.is_used) continue;
    squares += mark.residual_px.squaredNorm();
    count += 2;
  }
  return count > 0 ? pixel_mm() * std::sqrt(squares / count) : 0;
}

std::size_t ScanOrientation::misread() const {
  return std::size_t(std::count_if(choice.fit.marks.begin(), choice.fit.marks.end(),
                                   [](const FilmMarkResidual& mark) { return !mark.is_used; }));
}

Result<ScanOrientation> oriented_scan(const FilmCalibration& calibration, const ScanMarks& found) {
  std::vector<FilmMark> marks;
  for (const MarkReading& read : found.marks)
    for (const CalibratedMark& known : calibration.marks)
      if (known.name == read.mark)
        marks.push_back({.name = read.mark, .film_mm = known.film_mm, .pixel = read.position});
  // Four marks leave an affine transformation two checks.
  auto choice = choose_film_model(marks, {});
  if (choice && marks.size() >= 4)
    if (auto affine = fit_film(marks, FilmModel::kAffine, {})) choice->fit = *std::move(affine);
  if (!choice)
    return fail(Errc::kIllPosed,
                fmt::format("{} marks whose positions do not determine a transformation", marks.size()));
  return ScanOrientation{*std::move(choice), film_deformation(marks, {}), marks.size()};
}

}  // namespace collinea
