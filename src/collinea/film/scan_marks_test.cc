// SPDX-License-Identifier: Apache-2.0
#include "collinea/film/scan_marks.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/feature/fiducial_search.h"
#include "collinea/synthetic/film.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// Scans of a small film, 24 mm wide with eight marks of one kind, as simulate() renders those of a whole one.
FilmTruth small_film(MarkKind kind, double pixel_mm) {
  SurveyOptions flight;
  flight.strips = 1;
  flight.images_per_strip = 3;
  flight.control_points = flight.check_points = 2;
  FilmTruth film = *make_film_survey(flight, {.scan_um = 400}, {});
  film.pixel_mm = pixel_mm;
  film.calibration.size_mm = {24, 24};
  for (std::size_t i = 0; i < film.calibration.marks.size(); ++i) {
    CalibratedMark& mark = film.calibration.marks[i];
    mark.film_mm *= 8.5 / 109.8;
    mark.kind = kind;
  }
  film.wear.scratches = film.wear.dust = 0;
  film.wear.grain_grey = 5 * pixel_mm / 0.015;  // 5 in a pixel
  film.scans.clear();
  for (const auto& [id, image] : film.truth.block.images)
    film.scans.emplace(id, worn_scan(film.calibration, pixel_mm, film.wear, Random(31, id.value)));
  return film;
}

struct Errors {
  int count = 0;
  double chi2 = 0;
};

Errors errors_of(MarkKind kind, double pixel_mm) {
  const FilmTruth film = small_film(kind, pixel_mm);
  Errors out;
  for (const auto& [id, scan] : film.scans) {
    const GreyImage raster = *render_scan(film, id, {.threads = 2});
    const auto found = find_fiducials(
        raster, film.calibration,
        {.predicted = predicted_scan(film.calibration, raster.width, raster.height, pixel_mm, 0), .radius_mm = 2}, {});
    for (const FoundFiducial& one : found) {
      const auto mark = std::find_if(film.calibration.marks.begin(), film.calibration.marks.end(),
                                     [&](const CalibratedMark& m) { return m.name == one.name; });
      const Vector2d off = one.mark.pixel - scan.pixel_of(mark->film_mm);
      out.chi2 += off.dot(one.mark.covariance.inverse() * off);
      ++out.count;
    }
  }
  return out;
}

// Coarse scans, whose lines are 1.5 to 2.5 pixels wide, say truly how well their crosses and dots are read where grain
// is what errs. Of 24 marks chi-squared over its 48 degrees of freedom has a standard deviation of sqrt(2 / 48) = 0.2;
// four of them.
TEST(ScanMarks, ErrorsInRenderedCoarseScansAreThoseOfTheirCovariances) {
  for (const MarkKind kind : {MarkKind::kCross, MarkKind::kDot})
    for (const double um : {100.0, 60.0}) {
      const Errors e = errors_of(kind, 1e-3 * um);
      ASSERT_EQ(e.count, 24) << word_of(kind) << um;
      EXPECT_NEAR(e.chi2 / (2 * e.count), 1, 4 * std::sqrt(2.0 / 48)) << word_of(kind) << um;
    }
}

}  // namespace
}  // namespace collinea
