// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/film.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

SurveyOptions small_flight() {
  SurveyOptions o;
  o.strips = 1;
  o.images_per_strip = 2;
  o.control_points = 2;
  o.check_points = 2;
  return o;
}

FilmOptions coarse_film() {
  FilmOptions film;
  film.scan_um = 400;
  return film;
}

TEST(FilmScan, PixelAndFilmAreInverse) {
  ScanWear wear;
  wear.film_local_um = 100;
  const FilmTruth film = *make_film_survey(small_flight(), {.scan_um = 400, .wear = wear}, {});
  const FilmScan& scan = film.scans.at(ImageId{0});
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0), {109, -108}, {-60, 77}})
    EXPECT_NEAR((scan.film_of(scan.pixel_of(at)) - at).norm(), 0, 1e-7);
}

// Over many scans the displacement has the standard deviation that was asked for.
TEST(FilmScan, LocalDeformationIsAsLargeAsAsked) {
  ScanWear wear;
  wear.film_local_um = 7;
  double squares = 0;
  int count = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const FilmScan scan = worn_scan({}, 0.04, wear, Random(5, i));
    for (const double x : {-100.0, -30.0, 50.0})
      for (const double y : {-80.0, 20.0, 100.0}) {
        squares += scan.displacement_mm({x, y}).squaredNorm();
        count += 2;
      }
  }
  EXPECT_NEAR(1e3 * std::sqrt(squares / count), 7, 0.7);
}

TEST(Film, DoesNotDependOnThreads) {
  const FilmTruth film = *make_film_survey(small_flight(), coarse_film(), {});
  const auto one = render_scan(film, ImageId{1}, {.threads = 1}), two = render_scan(film, ImageId{1}, {.threads = 2});
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->data, two->data);
  EXPECT_EQ(one->width, 580);
}

// Centroid of what is brighter than the ground round a position; of a mark that is the same turned by 180 degrees its
// middle, whatever the curve of grey values.
Eigen::Vector2d centroid(const GreyImage& scan, const Eigen::Vector2d& about, int half) {
  const int left = int(about.x()) - half, top = int(about.y()) - half;
  const double ground = scan.at(left, top);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0;
  for (int y = top; y <= top + 2 * half; ++y)
    for (int x = left; x <= left + 2 * half; ++x) {
      const double light = scan.at(x, y) - ground;
      sum += light * Eigen::Vector2d(x + 0.5, y + 0.5);
      weight += light;
    }
  return sum / weight;
}

// Lines of 0.15 mm are one pixel and a half wide. Whole grey values leave a hundredth of a pixel (0.3 grey of
// each of some hundred pixels, six from the middle, of a light of 2000); three by three samples left 0.07.
TEST(Film, MarksLieWhereTheTruthSays) {
  FilmOptions options = coarse_film();
  options.scan_um = 100;
  options.wear = {.film_local_um = 0, .grain_grey = 0, .scratches = 0, .dust = 0};
  SurveyOptions flight = small_flight();
  flight.control_points = flight.check_points = 0;
  const FilmTruth film = *make_film_survey(flight, options, {});
  const GreyImage scan = *render_scan(film, ImageId{0}, {});
  double squares = 0;
  for (const CalibratedMark& mark : film.calibration.marks) {
    const Eigen::Vector2d at = film.scans.at(ImageId{0}).pixel_of(mark.film_mm);
    squares += (centroid(scan, at, 12) - at).squaredNorm();
  }
  EXPECT_LT(std::sqrt(squares / (2 * double(film.calibration.marks.size()))), 0.02);
}

// The file of the local deformation and the transformation of the scan are where a mark lies, to the digits written.
TEST(Film, LocalDeformationIsPartOfTheTruth) {
  const TestFolder folder;
  SurveyOptions flight;
  flight.strips = flight.images_per_strip = 1;
  flight.control_points = 3;
  flight.check_points = 1;
  const FilmOptions options{.scan_um = 400, .wear = {.film_local_um = 40}};
  const auto done = simulate(flight, options, folder / "film", {.threads = 2});
  ASSERT_TRUE(done) << done.error().message;
  const FilmTruth film = *make_film_survey(flight, options, {});
  const FilmScan& scan = film.scans.begin()->second;
  std::ifstream in(folder / "film/truth/deformation/IMG_0001.csv");
  std::string line;
  ASSERT_TRUE(std::getline(in, line));
  int rows = 0;
  double largest = 0;
  char comma;
  for (double x, y, dx, dy; in >> x >> comma >> y >> comma >> dx >> comma >> dy; ++rows) {
    EXPECT_LT((scan.affine.pixel_of({x + dx, y + dy}) - scan.pixel_of({x, y})).norm(), 1e-9);
    largest = std::max(largest, std::abs(dx));
  }
  EXPECT_EQ(rows, 47 * 47);
  EXPECT_GT(largest, 0.02);
}

// Control is measured where the scan shows it: the board is painted there, white and black about its centre.
TEST(Film, ControlLiesWhereTheScanShowsIt) {
  SurveyOptions flight = small_flight();
  flight.measurement_sigma_px = 0;
  FilmOptions options = coarse_film();
  options.scan_um = 150;
  options.wear = {.scan_turn_deg = 1, .grain_grey = 0, .scratches = 0, .dust = 0};
  const FilmTruth film = *make_film_survey(flight, options, {});
  int seen = 0;
  for (const ControlObservation& control : film.truth.block.control_observations) {
    if (control.image != ImageId{0}) continue;
    const GreyImage scan = *render_scan(film, control.image, {.threads = 2});
    const Eigen::Vector2d at = scan_pixel_of(film, control.image, control.pixel);
    // A chequerboard is the same turned by 180 degrees about its centre, and only there.
    const auto asymmetry = [&](double dx, double dy) {
      double sum = 0;
      for (double v = -2.5; v <= 2.5; v += 0.5)
        for (double u = -2.5; u <= 2.5; u += 0.5)
          sum += std::abs(bilinear(scan, at.x() + dx + u, at.y() + dy + v) -
                          bilinear(scan, at.x() + dx - u, at.y() + dy - v));
      return sum;
    };
    for (const Eigen::Vector2d& off : {Eigen::Vector2d(1, 0), {-1, 0}, {0, 1}, {0, -1}})
      EXPECT_LT(asymmetry(0, 0), 0.7 * asymmetry(off.x(), off.y())) << at.transpose();
    ++seen;
  }
  EXPECT_GE(seen, 2);
}

TEST(Film, RefractionMovesTheCornersOutwards) {
  const FilmTruth film = *make_film_survey(small_flight(), {.scan_um = 400, .wear = {0, 0, 0, 0}}, {});
  const Camera& camera = film.truth.block.cameras.begin()->second;
  const Eigen::Vector2d middle(camera.width_px / 2.0, camera.height_px / 2.0);
  const auto shift_um = [&](const Eigen::Vector2d& pixel) {
    const auto& scan = film.scans.at(ImageId{0});
    const Eigen::Vector2d straight = 0.4 * (pixel - middle);
    const Eigen::Vector2d film_mm = scan.film_of(scan_pixel_of(film, ImageId{0}, pixel));
    return 1e3 * (Eigen::Vector2d(film_mm.x(), -film_mm.y()) - straight).dot(straight.normalized());
  };
  // f tan a (1 + tan^2 a) 14.6e-6 at 1226 m over ground of 310 m: 4.2 um where tan a is 0.95; tilts change it by a
  // tenth.
  EXPECT_NEAR(shift_um({10, 10}), 4.2, 0.8);
  EXPECT_NEAR(shift_um(middle + Eigen::Vector2d(5, 0)), 0, 0.3);
}

}  // namespace
}  // namespace collinea
