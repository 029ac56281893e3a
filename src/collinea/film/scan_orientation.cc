// SPDX-License-Identifier: Apache-2.0
#include "collinea/film/scan_orientation.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/feature/fiducial_search.h"
#include "collinea/io/film_calibration_file.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

// Marks are blurred over more than this: finer pixels say nothing more of where they are, and take the longer.
constexpr double kCoarsestForMarks_mm = 0.0305;
constexpr int kMostShrink = 8;

// By how much a scan is reduced for its marks. One that was learnt has the pixels of the scans.
Result<int> mark_shrink(const std::filesystem::path& file, const MarkSearch& search) {
  if (!search.learnt.empty()) return 1;
  COLLINEA_TRY(const ImageHeader header, read_image_header(file));
  const double px_per_mm = predicted_scan(search.calibration, header.width_px, header.height_px, search.pixel_mm,
                                          search.options.turned_deg / 90)
                               .parameters[3];
  int shrink = 1;
  while (shrink < kMostShrink && 2 * shrink <= kCoarsestForMarks_mm * std::abs(px_per_mm)) shrink *= 2;
  return shrink;
}

}  // namespace

double ScanOrientation::pixel_mm() const {
  return 1 / std::sqrt(std::abs(scan_from_film().by_film(Eigen::Vector2d::Zero()).determinant()));
}

double ScanOrientation::rms_mm() const {
  double squares = 0;
  int count = 0;
  for (const FilmMarkResidual& mark : choice.fit.marks) {
    if (!mark.is_used) continue;
    squares += mark.residual_px.squaredNorm();
    count += count_of(mark.coordinates);
  }
  return count > 0 ? pixel_mm() * std::sqrt(squares / count) : 0;
}

std::size_t ScanOrientation::misread() const {
  return std::size_t(std::count_if(choice.fit.marks.begin(), choice.fit.marks.end(),
                                   [](const FilmMarkResidual& mark) { return !mark.is_used; }));
}

Result<> check_film(const FilmScanOptions& options) {
  if (!options.calibration && (options.pixel_um || options.marks != ScanMarkOptions{}))
    return fail(Errc::kBadInput, "only scans of film have marks: their calibration is missing",
                {"film"_option, "film_pixel_um"_option, "mark_kind"_option, "mark_at"_option, "turned_deg"_option,
                 "search_mm"_option});
  return {};
}

Result<MarkSearch> film_search(const FilmScanOptions& options, const std::filesystem::path& first_scan) {
  COLLINEA_TRY(const FilmCalibration calibration, read_film_calibration(*options.calibration));
  if (calibration.marks.empty())
    return fail(Errc::kBadInput,
                options.calibration->string() + ": no marks, by which scans are oriented: lines mark NAME X Y",
                {"film"_option});
  std::optional<double> pixel_mm;
  if (options.pixel_um) pixel_mm = 1e-3 * *options.pixel_um;
  return mark_search(calibration, pixel_mm, options.marks, first_scan);
}

Result<ScanOrientation> orient_scan(const std::filesystem::path& file, const MarkSearch& search, const Run& run) {
  COLLINEA_TRY(const int shrink, mark_shrink(file, search));
  COLLINEA_TRY(const GreyImage scan, read_grey(file, shrink));
  MarkSearch reduced = search;
  if (reduced.pixel_mm) *reduced.pixel_mm *= shrink;
  COLLINEA_TRY(ScanMarks marks, find_marks(scan, file.stem().string(), reduced, run).map_error([](Error error) {
    return std::move(error).about("film_pixel_um"_option);
  }));
  for (MarkReading& mark : marks.marks) {
    mark.position *= shrink;
    mark.sigma *= shrink;
  }
  return oriented_scan(search.calibration, marks);
}

Result<ScanOrientation> oriented_scan(const FilmCalibration& calibration, const ScanMarks& found) {
  std::vector<FilmMark> marks;
  double variance_px2 = 0, variance_mm2 = 0;
  int coordinates = 0;
  for (const MarkReading& read : found.marks)
    for (const CalibratedMark& known : calibration.marks)
      if (known.name == read.mark) {
        marks.push_back(
            {.name = read.mark, .film_mm = known.film_mm, .pixel = read.position, .coordinates = known.coordinates});
        coordinates += count_of(known.coordinates);
        variance_px2 += read.sigma * read.sigma;
        variance_mm2 += known.sigma_mm * known.sigma_mm;
      }
  // Four marks leave an affine transformation two checks.
  auto choice = choose_film_model(marks, {});
  if (choice && coordinates >= 8)
    if (auto affine = fit_film(marks, FilmModel::kAffine, {})) choice->fit = *std::move(affine);
  if (!choice)
    return fail(Errc::kIllPosed,
                fmt::format("{} marks whose positions do not determine a transformation", marks.size()));
  ScanOrientation oriented{*std::move(choice), film_deformation(marks, {}), marks.size()};
  const double pixel_mm = oriented.pixel_mm();
  oriented.mark_sigma_px = std::sqrt((variance_px2 + variance_mm2 / (pixel_mm * pixel_mm)) / double(marks.size()));
  return oriented;
}

}  // namespace collinea
