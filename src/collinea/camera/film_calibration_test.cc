// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_calibration.h"

#include <gtest/gtest.h>

#include <cmath>

namespace collinea {
namespace {

using Eigen::Vector2d;

FilmCalibration example() {
  FilmCalibration c;
  c.principal_distance_mm = 153.358;
  c.principal_point_mm = c.symmetry_point_mm = {-0.006, 0.006};
  c.radial = {0.8878e-4, -0.1528e-7, 0.5256e-12, 0};
  c.decentring = {0.1346e-6, 0.1224e-7};
  return c;
}

const Vector2d kPositions[] = {{0, 0}, {100, 30}, {-60, 95}, {-106, -106}, {12, -80}};

TEST(FilmCalibration, ItsCameraSeesTheCorrectedCoordinates) {
  FilmCalibration c = example();
  c.decentring = {3e-6, -2e-6};
  for (const Vector2d& film : kPositions) {
    const Vector2d corrected = corrected_mm(c, film);
    const Vector2d seen = normalized(film_camera(c), {film.x(), -film.y()});
    EXPECT_LT((c.principal_distance_mm * Vector2d(seen.x(), -seen.y()) - corrected).norm(), 1e-9);
  }
}

TEST(FilmCalibration, AnotherCentreOfSymmetryCostsTheCameraNanometres) {
  FilmCalibration c = example();
  c.symmetry_point_mm = {0.004, 0.009};
  for (const Vector2d& film : kPositions) {
    const Vector2d seen = normalized(film_camera(c), {film.x(), -film.y()});
    EXPECT_LT((c.principal_distance_mm * Vector2d(seen.x(), -seen.y()) - corrected_mm(c, film)).norm(), 5e-6);
  }
}

TEST(FilmCalibration, TheCameraOfAScanSeesTheSameDirections) {
  FilmCalibration c = example();
  c.decentring = {3e-6, -2e-6};
  FilmTransformation t;
  t.model = FilmModel::kAffine;
  for (const double rotation : {0.02, 1.6, -3.1}) {
    t.parameters = (Eigen::VectorXd(6) << 10250, 10378, rotation, 80.01, 79.96, 4e-4).finished();
    const auto scan = scan_camera(c, t);
    ASSERT_TRUE(scan);
    for (const Vector2d& film : kPositions) {
      const Vector2d by_film = normalized(film_camera(c), {film.x(), -film.y()});
      const Vector2d by_scan = normalized(scan->camera, t.pixel_of(film));
      const double s = std::sin(scan->rotation_rad), k = std::cos(scan->rotation_rad);
      EXPECT_LT((by_scan - Vector2d(k * by_film.x() - s * by_film.y(), s * by_film.x() + k * by_film.y())).norm(),
                1e-10);
    }
  }
  t.is_mirrored = true;
  EXPECT_FALSE(scan_camera(c, t));
  t = {FilmModel::kProjective, false, 1, (Eigen::VectorXd(8) << 0, 0, 0, 80, 80, 0, 1e-6, 0).finished(), {}};
  EXPECT_FALSE(scan_camera(c, t));
}

TEST(FilmCalibration, ARadialTableBecomesItsPolynomial) {
  const std::vector<double> radii = {20, 40, 63, 88, 107, 128};
  std::vector<double> distances;
  const FilmCalibration c = example();
  for (const double r : radii)
    distances.push_back(r * (c.radial[0] + c.radial[1] * r * r + c.radial[2] * r * r * r * r));
  const auto fit = fit_radial(radii, distances);
  ASSERT_TRUE(fit);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR((*fit)[i], c.radial[i], 1e-9 * std::pow(128, -2.0 * double(i)));
  EXPECT_NEAR(fit_radial(std::vector<double>{100}, std::vector<double>{0.01}).value()[0], 1e-4, 1e-12);
  EXPECT_FALSE(fit_radial({}, {}));
  EXPECT_FALSE(fit_radial(std::vector<double>{5, 5}, std::vector<double>{1, 1}));
  EXPECT_FALSE(fit_radial(std::vector<double>{-5, 5}, std::vector<double>{1, 1}));
  EXPECT_FALSE(fit_radial(std::vector<double>{0}, std::vector<double>{0}));
}

TEST(FilmCalibration, CorrectionHasAnInverse) {
  FilmCalibration c;
  c.principal_distance_mm = 153;
  c.principal_point_mm = {0.3, -0.2};
  c.symmetry_point_mm = {0.1, 0.2};
  c.radial = {1e-3, -3e-7, 2e-12, 1e-17};
  c.decentring = {1e-6, -2e-6};
  for (const Eigen::Vector2d& film_mm : {Eigen::Vector2d(0, 0), {110, 110}, {-90, 40}})
    EXPECT_NEAR((distorted_mm(c, corrected_mm(c, film_mm)) - film_mm).norm(), 0, 1e-9);
}

TEST(FilmCalibration, ThePictureIsWhatTheMarksLeave) {
  FilmCalibration c;
  c.size_mm = {230, 230};
  c.mark_size_mm = 2;  // and ground of as much again round it: 3 mm to each side
  EXPECT_EQ(film_image_size(c), Eigen::Vector2d(0.98 * 230, 0.98 * 230));
  c.marks = {{.name = "1", .film_mm = {110, 0}}, {.name = "2", .film_mm = {-112, 1}}};
  EXPECT_NEAR(film_image_size(c).x(), 214, 1e-12);  // a mark at the side costs a strip there
  EXPECT_NEAR(film_image_size(c).y(), 0.98 * 230, 1e-12);
  c.marks = {{.name = "1", .film_mm = {106, -106}}};  // one in a corner costs both
  EXPECT_NEAR((film_image_size(c) - Eigen::Vector2d(206, 206)).norm(), 0, 1e-12);
  c.image_size_mm = Eigen::Vector2d(200, 190);
  EXPECT_EQ(film_image_size(c), Eigen::Vector2d(200, 190));
}

}  // namespace
}  // namespace collinea
