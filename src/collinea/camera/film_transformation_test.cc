// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_transformation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "collinea/camera/internal/test_film.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using namespace test;

TEST(FilmTransformation, DerivativesAreThoseOfDifferences) {
  for (const FilmModel model : kModels) {
    FilmTransformation t = example(model);
    for (const bool mirrored : {false, true}) {
      t.is_mirrored = mirrored;
      const Vector2d film(-83.5, 41.2);
      const auto by = t.by_parameters(film);
      for (int k = 0; k < t.parameters.size(); ++k) {
        const double step = k >= 6 ? 1e-8 : 1e-5;
        FilmTransformation more = t, less = t;
        more.parameters[k] += step;
        less.parameters[k] -= step;
        const Vector2d numeric = (more.pixel_of(film) - less.pixel_of(film)) / (2 * step);
        EXPECT_LT((by.col(k) - numeric).norm(), 1e-5 * (1 + numeric.norm())) << word_of(model) << k;
      }
      for (int k = 0; k < 2; ++k) {
        const Vector2d step = 1e-4 * Vector2d::Unit(k);
        const Vector2d numeric = (t.pixel_of(film + step) - t.pixel_of(film - step)) / 2e-4;
        EXPECT_LT((t.by_film(film).col(k) - numeric).norm(), 1e-5);
      }
      EXPECT_LT((t.film_of(t.pixel_of(film)).value() - film).norm(), 1e-10);
    }
  }
}

TEST(FilmTransformation, AxisDirectionsAndTheRouteWithoutMarks) {
  // 1200 dpi: 25.4 / 1200 mm (Karfis 1.3; the print has 2.54 / dpi).
  const FilmTransformation t = without_marks({5000, 4000}, 25.4 / 1200);
  EXPECT_LT((t.film_of({5000 + 1200, 4000}).value() - Vector2d(25.4, 0)).norm(), 1e-9);
  EXPECT_LT((t.film_of({5000, 4000 + 1200}).value() - Vector2d(0, -25.4)).norm(), 1e-9);
  EXPECT_TRUE(t.pixel_with_covariance({10, 10}).covariance.isZero());
  // Karfis (1519, 1754): 400 dpi are 64 um (63.5); 550 dpi are 46.2 um, where he prints 49.
  EXPECT_NEAR(without_marks({0, 0}, 25.4 / 400).film_of({1, 0}).value().x(), 0.0635, 5e-8);
  EXPECT_NEAR(without_marks({0, 0}, 25.4 / 550).film_of({1, 0}).value().x(), 0.0462, 5e-5);
}

}  // namespace
}  // namespace collinea
