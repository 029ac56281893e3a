// SPDX-License-Identifier: Apache-2.0
#include "collinea/film/ideal_image.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/test_folder.h"
#include "collinea/film/scan_orientation.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

FilmCalibration calibration() {
  FilmCalibration c;
  c.camera = "test camera";
  c.principal_distance_mm = 153;
  c.principal_point_mm = {0.3, -0.2};
  c.symmetry_point_mm = {0.1, 0.2};
  c.radial = {1e-4, -2e-8, 1e-13, 0};
  c.decentring = {2e-7, -1e-7};
  c.image_size_mm = Eigen::Vector2d(90, 80);
  c.size_mm = {100, 100};
  return c;
}

// A scan turned by a degree, with two scales and shear; 0.2 mm a pixel.
FilmTransformation turned_scan() {
  FilmTransformation t;
  t.model = FilmModel::kAffine;
  t.parameters.resize(6);
  t.parameters << 263.3, 258.8, 0.02, 5.01, 4.985, 0.003;
  t.covariance = Eigen::MatrixXd::Zero(6, 6);
  return t;
}

// Grey values of the film, of details of some millimetres.
double grey_at(const Eigen::Vector2d& film_mm) {
  return 120 + 50 * std::sin(0.9 * film_mm.x() + 0.3) * std::cos(0.7 * film_mm.y()) + 30 * std::sin(0.4 * film_mm.y());
}

TEST(IdealImage, PixelsAndFilmAreInverse) {
  const IdealImage ideal = ideal_image(calibration(), 0.2);
  EXPECT_EQ(ideal.camera.width_px, 450);
  EXPECT_EQ(ideal.camera.height_px, 400);
  EXPECT_FALSE(ideal.camera.prior.calibrate);
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0, 0), {450, 400}, {13.2, 377}})
    EXPECT_NEAR((ideal.pixel_of(ideal.film_of(pixel)) - pixel).norm(), 0, 1e-8);
}

// Image coordinates of the ideal are those that the calibration corrects, whatever the lens does.
TEST(IdealImage, RaysAreThoseOfTheFilmCamera) {
  const FilmCalibration c = calibration();
  const IdealImage ideal = ideal_image(c, 0.2);
  for (const Eigen::Vector2d& film_mm : {Eigen::Vector2d(0, 0), {40, -35}, {-44, 12}}) {
    const Eigen::Vector2d corrected = corrected_mm(c, film_mm) / c.principal_distance_mm;
    const Eigen::Vector2d ray = normalized(ideal.camera, ideal.pixel_of(film_mm));
    EXPECT_NEAR((ray - Eigen::Vector2d(corrected.x(), -corrected.y())).norm(), 0, 1e-12);
  }
}

TEST(IdealImage, ShowsWhatTheFilmShows) {
  const FilmTransformation scan_from_film = turned_scan();
  GreyImage scan(530, 520);
  for (int y = 0; y < scan.height; ++y)
    for (int x = 0; x < scan.width; ++x)
      scan.at(x, y) = std::uint8_t(std::lround(grey_at(*scan_from_film.film_of({x + 0.5, y + 0.5}))));
  const IdealImage ideal = ideal_image(calibration(), 0.2);
  const auto seen = resampled_scan(scan, scan_from_film, ideal, {});
  EXPECT_EQ(resampled_scan(scan, scan_from_film, ideal, {.threads = 2}).data, seen.data);
  double squares = 0;
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x) {
      const double difference = seen.at(x, y) - grey_at(ideal.film_of({x + 0.5, y + 0.5}));
      squares += difference * difference;
      ASSERT_LT(std::abs(difference), 3) << x << " " << y;
    }
  // Rounding of scan and ideal: each has a standard deviation of 0.29, and cubic convolution averages a little.
  EXPECT_LT(std::sqrt(squares / double(seen.data.size())), 0.45);
}

TEST(IdealImage, IsZeroWhereTheScanEnds) {
  const GreyImage scan(250, 520, 1, 100);  // half of the film
  const auto seen = resampled_scan(scan, turned_scan(), ideal_image(calibration(), 0.2), {});
  EXPECT_EQ(seen.at(10, 200), 100);
  EXPECT_EQ(seen.at(440, 200), 0);
}

TEST(IdealImage, KeepsColoursAndGreyAsTheyAre) {
  const TestFolder folder;
  Raster<std::uint8_t> grey(530, 520, 1, 90), colour(530, 520, 3, 90);
  for (std::size_t i = 0; i < colour.data.size(); i += 3) colour.data[i] = 180;
  ASSERT_TRUE(write_png(folder / "grey.png", grey));
  ASSERT_TRUE(write_png(folder / "colour.png", colour));
  const IdealImage ideal = ideal_image(calibration(), 0.2);
  for (const char* name : {"grey", "colour"}) {
    const auto out = folder / (std::string(name) + ".jpg");
    ASSERT_TRUE(write_ideal_image(folder / (std::string(name) + ".png"), turned_scan(), ideal, out, {}));
    EXPECT_EQ(*channels_of(out), name == std::string("grey") ? 1 : 3);
  }
  const auto seen = read_colour(folder / "colour.jpg");
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->at(200, 200, 0), 180, 2);
  EXPECT_NEAR(seen->at(200, 200, 1), 90, 2);
}

TEST(IdealImage, NamesItsFile) {
  EXPECT_EQ(ideal_image_name("a/B.JPG"), "a/B.JPG");
  EXPECT_EQ(ideal_image_name("strip 1/0007.tif"), "strip 1/0007.tif.jpg");
}

// Shrunk by 30 ppm only, which a single scan could not tell from nothing.
TEST(ScanOrientation, IsAffineFromFourMarksOn) {
  FilmCalibration c = calibration();
  ScanMarks found;
  const FilmTransformation truth = turned_scan();
  int i = 0;
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(-45, -45), {45, -45}, {45, 45}, {-45, 45}}) {
    c.marks.push_back({.name = std::to_string(++i), .film_mm = at});
    found.marks.push_back({std::to_string(i), truth.pixel_of(at), 0.1});
  }
  const auto four = oriented_scan(c, found);
  ASSERT_TRUE(four) << four.error().message;
  EXPECT_EQ(four->scan_from_film().model, FilmModel::kAffine);
  EXPECT_NEAR(four->rms_mm(), 0, 1e-9);
  EXPECT_NEAR(four->pixel_mm(), 0.2, 1e-3);
  EXPECT_NEAR((four->scan_from_film().parameters - truth.parameters).norm(), 0, 1e-6);
  found.marks.resize(2);
  EXPECT_EQ(oriented_scan(c, found)->scan_from_film().model, FilmModel::kSimilarity);
  found.marks.resize(1);
  const auto one = oriented_scan(c, found);
  ASSERT_FALSE(one);
  EXPECT_EQ(one.error().code, Errc::kIllPosed);
}

}  // namespace
}  // namespace collinea
