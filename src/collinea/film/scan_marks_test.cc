// SPDX-License-Identifier: Apache-2.0
#include "collinea/film/scan_marks.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
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
  double chi2 = 0, outwards = 0, sigma_outwards = 0;
};

// e' C^-1 e of all marks of a scan: what the tone of the scan adds to their covariances is common to all of them.
double joint_chi2(const std::vector<FoundFiducial>& found, const Eigen::VectorXd& off) {
  Eigen::VectorXd by_tone(off.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    by_tone.segment<2>(2 * Eigen::Index(i)) = found[i].mark.sigma_tone * found[i].mark.by_tone;
  Eigen::MatrixXd covariance = by_tone * by_tone.transpose();
  for (std::size_t i = 0; i < found.size(); ++i)
    covariance.block<2, 2>(2 * Eigen::Index(i), 2 * Eigen::Index(i)) = found[i].mark.covariance;
  return off.dot(covariance.llt().solve(off));
}

Errors errors_of(MarkKind kind, double pixel_mm) {
  const FilmTruth film = small_film(kind, pixel_mm);
  Errors out;
  for (const auto& [id, scan] : film.scans) {
    const GreyImage raster = *render_scan(film, id, {.threads = 2});
    const auto found = find_fiducials(
        raster, film.calibration,
        {.predicted = predicted_scan(film.calibration, raster.width, raster.height, pixel_mm, 0), .radius_mm = 2}, {});
    Eigen::VectorXd offs(2 * Eigen::Index(found.size()));
    for (const FoundFiducial& one : found) {
      const auto mark = std::find_if(film.calibration.marks.begin(), film.calibration.marks.end(),
                                     [&](const CalibratedMark& m) { return m.name == one.name; });
      const Vector2d off = one.mark.pixel - scan.pixel_of(mark->film_mm);
      const Vector2d outwards = Vector2d(mark->film_mm.x(), -mark->film_mm.y()).normalized();
      offs.segment<2>(2 * (&one - found.data())) = off;
      out.outwards += off.dot(outwards);
      out.sigma_outwards += std::sqrt(outwards.dot(one.mark.covariance * outwards));
      ++out.count;
    }
    out.chi2 += joint_chi2(found, offs);
  }
  return out;
}

class MarksInRenderedScans : public ::testing::TestWithParam<MarkKind> {};

// Coarse scans, whose lines are 1.5 to 3.5 pixels wide and whose grey values are light to the power 1 / 2.2, say truly
// how well their marks are read where grain is what errs. Of 24 marks chi-squared over its 48 degrees of freedom has a
// standard deviation of sqrt(2 / 48) = 0.2; four of them. And no mark is read outwards: the mean of 24 is within four
// of its standard deviations, which are at most those of a mark over the root of three scans, as the tone errs in all
// marks of a scan alike.
TEST_P(MarksInRenderedScans, ErrAsTheirCovariancesSayAndNotToOneSide) {
  for (const double um : {100.0, 60.0, 42.0}) {
    const Errors e = errors_of(GetParam(), 1e-3 * um);
    ASSERT_EQ(e.count, 24) << word_of(GetParam()) << um;
    EXPECT_NEAR(e.chi2 / (2 * e.count), 1, 4 * std::sqrt(2.0 / 48)) << word_of(GetParam()) << um;
    EXPECT_LT(std::abs(e.outwards), 4 * e.sigma_outwards / std::sqrt(3.0)) << word_of(GetParam()) << um;
  }
}

INSTANTIATE_TEST_SUITE_P(All, MarksInRenderedScans,
                         ::testing::Values(MarkKind::kCross, MarkKind::kDot, MarkKind::kRing, MarkKind::kCorner,
                                           MarkKind::kNotch),
                         [](const auto& kind) { return std::string(word_of(kind.param)); });

}  // namespace
}  // namespace collinea
