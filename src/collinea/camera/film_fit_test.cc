// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/film_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "collinea/camera/internal/test_film.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using namespace test;

TEST(FilmFit, ExactMarksGiveTheTruthBackWithBothSidesOfTheFilm) {
  Random random(1);
  for (const FilmModel model : kModels)
    for (const bool mirrored : {false, true}) {
      FilmTransformation truth = example(model);
      truth.is_mirrored = mirrored;
      const auto fit = fit_film(marks_of(truth, 0, random), model, {.pixel_mm = 1 / 80.0});
      ASSERT_TRUE(fit) << word_of(model);
      EXPECT_EQ(fit->transformation.is_mirrored, mirrored);
      EXPECT_LT((fit->transformation.parameters - truth.parameters).norm(), 1e-6) << word_of(model);
      EXPECT_EQ(fit->redundancy, 16 - parameter_count(model));
      double redundancy = 0;
      for (const auto& mark : fit->marks) redundancy += mark.redundancy.sum();
      EXPECT_NEAR(redundancy, fit->redundancy, 1e-9);
    }
}

TEST(FilmFit, MarksThatDetermineNothingAreRefused) {
  Random random(1);
  const auto marks = marks_of(example(FilmModel::kProjective), 0.1, random);
  const auto first = [&](std::size_t count) { return std::span(marks).first(count); };
  EXPECT_FALSE(fit_film(first(1), FilmModel::kSimilarity, {}));
  EXPECT_FALSE(fit_film(first(2), FilmModel::kTwoScales, {}));
  EXPECT_FALSE(fit_film(first(2), FilmModel::kAffine, {}));
  EXPECT_FALSE(fit_film(first(3), FilmModel::kProjective, {}));
  EXPECT_FALSE(fit_film(first(8), FilmModel::kRigid, {}));  // no size of a pixel
  auto twice = marks;
  for (auto& mark : twice) mark.film_mm = kEight[0];
  EXPECT_FALSE(fit_film(twice, FilmModel::kSimilarity, {}));
  auto line = marks;
  for (std::size_t i = 0; i < 8; ++i) line[i].film_mm = line[i].pixel = Vector2d(double(i), 2.0 * double(i));
  EXPECT_FALSE(fit_film(line, FilmModel::kAffine, {}));
  EXPECT_FALSE(fit_film(line, FilmModel::kProjective, {}));
  auto broken = marks;
  broken[3].pixel.x() = std::nan("");
  EXPECT_FALSE(fit_film(broken, FilmModel::kAffine, {}));
  broken = marks;
  broken[3].covariance(0, 0) = -1;
  EXPECT_FALSE(fit_film(broken, FilmModel::kAffine, {}));
  EXPECT_FALSE(choose_film_model({}, {}));
  EXPECT_FALSE(film_deformation(first(3), {}));  // no redundancy, no sigma
}

// Errors over covariances are chi-squared: of parameters, of a transformed position and of one brought back to the
// film, with the calibration as uncertain as its sigma says.
TEST(FilmFit, CovariancesMatchTheRealErrors) {
  for (const FilmModel model : kModels) {
    const FilmTransformation truth = example(model);
    const int seeds = 300, n = parameter_count(model);
    double sum = 0, at_film = 0, squares = 0;
    int within = 0;
    for (int seed = 0; seed < seeds; ++seed) {
      Random random(7, std::uint64_t(seed));
      auto marks = marks_of(truth, 0.3, random);
      for (auto& mark : marks) {
        mark.calibration_sigma_mm = 0.003;
        mark.film_mm += 0.003 * Vector2d(random.normal(), random.normal());
      }
      const auto fit =
          fit_film(marks, model, {.sigmas_are_known = true, .reject_misread = false, .pixel_mm = 1 / 80.0});
      ASSERT_TRUE(fit);
      const Eigen::VectorXd error = fit->transformation.parameters - truth.parameters;
      sum += error.dot(fit->transformation.covariance.inverse() * error);
      squares += fit->squares / fit->redundancy;
      const Vector2d film(60, -45), pixel = truth.pixel_of(film) + 0.3 * Vector2d(random.normal(), random.normal());
      const auto back = fit->transformation.film_with_covariance(pixel, 0.09 * Eigen::Matrix2d::Identity());
      const Vector2d off = back->position - film;
      const double chi2 = off.dot(back->covariance.inverse() * off);
      at_film += chi2;
      within += chi2 < 5.991;
    }
    EXPECT_NEAR(sum / seeds / n, 1, 4 * std::sqrt(2.0 / (seeds * n))) << word_of(model);
    EXPECT_NEAR(squares / seeds, 1, 4 * std::sqrt(2.0 / (seeds * (16 - n))));
    EXPECT_NEAR(at_film / seeds / 2, 1, 4 * std::sqrt(1.0 / seeds));
    EXPECT_NEAR(within / double(seeds), 0.95, 0.04);
  }
}

TEST(FilmFit, TheTestFindsWhatTheFilmNeeds) {
  for (const FilmModel model : kModels)
    for (const bool known : {true, false}) {
      FilmTransformation truth = example(model);
      if (model == FilmModel::kProjective) truth.parameters.tail<2>() *= 30;
      const FilmFitOptions options{.sigmas_are_known = known, .pixel_mm = 1 / 80.0};
      int chosen = 0;
      for (int seed = 0; seed < 200; ++seed) {
        Random random(11, std::uint64_t(seed));
        const auto choice = choose_film_model(marks_of(truth, 0.15, random), options);
        ASSERT_TRUE(choice);
        chosen += choice->fit.transformation.model == model;
      }
      // No larger one than needed in 95 of 100 cases and more; projective has none that is larger.
      EXPECT_GE(chosen / 200.0, 0.91) << word_of(model) << known;
    }
}

TEST(FilmFit, AMisreadMarkIsNamedAndLeftOut) {
  const FilmTransformation truth = example(FilmModel::kAffine);
  int found = 0, false_alarms = 0;
  for (int seed = 0; seed < 200; ++seed) {
    Random random(5, std::uint64_t(seed));
    auto marks = marks_of(truth, 0.3, random);
    const auto good = fit_film(marks, FilmModel::kAffine, {});
    for (const auto& mark : good->marks) false_alarms += !mark.is_used;
    marks[2].pixel += Vector2d(13, 2);
    const auto fit = fit_film(marks, FilmModel::kAffine, {});
    found += !fit->marks[2].is_used;
    EXPECT_NEAR(fit->marks[2].residual_px.x(), 13, 3);
    EXPECT_EQ(fit_film(marks, FilmModel::kAffine, {.reject_misread = false})->redundancy, 10);
  }
  EXPECT_EQ(found, 200);
  EXPECT_LE(false_alarms, 3);
}

TEST(FilmFit, DeformationComesBackWithinItsSigma) {
  FilmTransformation truth = example(FilmModel::kAffine);
  const double difference = 1e6 * (80.01 / 79.98 - 1);
  double sum_difference = 0, sum_shear = 0, sum_x = 0;
  const int seeds = 400;
  for (int seed = 0; seed < seeds; ++seed) {
    Random random(3, std::uint64_t(seed));
    const auto d = film_deformation(marks_of(truth, 0.3, random), {.sigmas_are_known = true, .pixel_mm = 1 / 80.0});
    ASSERT_TRUE(d && d->x_ppm);
    sum_difference += std::pow((d->difference_ppm.value - difference) / d->difference_ppm.sigma, 2);
    sum_shear += std::pow((d->shear_ppm.value - 300) / d->shear_ppm.sigma, 2);
    sum_x += std::pow((d->x_ppm->value - 125) / d->x_ppm->sigma, 2);
    EXPECT_TRUE(d->is_sheared && d->differs);
    EXPECT_NEAR(d->pixel_y_um.value, 1000 / 79.98, 6 * d->pixel_y_um.sigma);
  }
  for (const double sum : {sum_difference, sum_shear, sum_x}) EXPECT_NEAR(sum / seeds, 1, 4 * std::sqrt(2.0 / seeds));
}

// Marks in the middle of the sides lack the coordinate along their side: their pixels run along it as they like.
std::vector<FilmMark> side_marks_of_one(const FilmTransformation& t, double sigma_px, Random& random) {
  auto marks = marks_of(t, sigma_px, random);
  for (std::size_t i = 4; i < 8; ++i) {
    marks[i].coordinates = i < 6 ? MarkCoordinates::kX : MarkCoordinates::kY;
    const Vector2d along = t.by_film(marks[i].film_mm).col(i < 6 ? 1 : 0);
    marks[i].pixel += random.uniform(-3, 3) * along;
  }
  return marks;
}

TEST(FilmFit, MarksOfOneCoordinateGiveOneEquation) {
  Random random(4);
  for (const FilmModel model : kModels)
    for (const bool mirrored : {false, true}) {
      FilmTransformation truth = example(model);
      truth.is_mirrored = mirrored;
      const auto fit = fit_film(side_marks_of_one(truth, 0, random), model, {.pixel_mm = 1 / 80.0});
      ASSERT_TRUE(fit) << word_of(model);
      EXPECT_LT((fit->transformation.parameters - truth.parameters).norm(), 1e-6) << word_of(model);
      EXPECT_EQ(fit->redundancy, 12 - parameter_count(model));
      double redundancy = 0;
      for (const auto& mark : fit->marks) redundancy += mark.redundancy.sum();
      EXPECT_NEAR(redundancy, fit->redundancy, 1e-9);
      EXPECT_EQ(fit->marks[4].coordinates, MarkCoordinates::kX);
    }
}

// e' C^-1 e of p parameters with known sigmas is chi-squared with p degrees of freedom, v' P v with 12 - p; means of n.
// The calibration of these marks errs, too, along the coordinate that they have.
TEST(FilmFit, CovarianceWithMarksOfOneCoordinateIsThatOfTheErrors) {
  constexpr int kTrials = 800;
  constexpr double kSigma_px = 0.4, kCalibration_mm = 0.004;
  for (const FilmModel model : kModels) {
    const FilmTransformation truth = example(model);
    const int parameters = parameter_count(model);
    double errors = 0, squares = 0, w2 = 0;
    for (std::uint64_t trial = 1; trial <= kTrials; ++trial) {
      Random random(trial, 3);
      auto marks = side_marks_of_one(truth, kSigma_px, random);
      for (FilmMark& mark : marks) {
        mark.calibration_sigma_mm = kCalibration_mm;
        mark.film_mm += kCalibration_mm * Vector2d(random.normal(), random.normal());
        if (mark.coordinates == MarkCoordinates::kX) mark.film_mm.y() += random.uniform(-2, 2);  // about where it is
      }
      const auto fit =
          fit_film(marks, model, {.sigmas_are_known = true, .reject_misread = false, .pixel_mm = 1 / 80.0});
      ASSERT_TRUE(fit);
      const Eigen::VectorXd e = fit->transformation.parameters - truth.parameters;
      errors += e.dot(fit->transformation.covariance.ldlt().solve(e));
      squares += fit->squares;
      w2 += fit->marks[6].w.squaredNorm();  // one coordinate: one w
    }
    EXPECT_NEAR(errors / kTrials, parameters, 4 * std::sqrt(2.0 * parameters / kTrials)) << word_of(model);
    EXPECT_NEAR(squares / kTrials, 12 - parameters, 4 * std::sqrt(2.0 * (12 - parameters) / kTrials)) << word_of(model);
    EXPECT_NEAR(w2 / kTrials, 1, 4 * std::sqrt(2.0 / kTrials)) << word_of(model);
  }
}

// Four frame edges in the middle of the sides: left and right have x, above and below y, or the other way round.
TEST(FilmFit, FourMarksOfOneCoordinateDetermineNoScale) {
  Random random(2);
  const FilmTransformation truth = example(FilmModel::kRigid);
  const auto all = marks_of(truth, 0, random);
  std::vector<FilmMark> along(all.begin() + 4, all.end()), across = along;
  for (std::size_t i = 0; i < 4; ++i) {
    along[i].coordinates = i < 2 ? MarkCoordinates::kY : MarkCoordinates::kX;   // they tell the rotation
    across[i].coordinates = i < 2 ? MarkCoordinates::kX : MarkCoordinates::kY;  // they tell scales, no rotation
  }
  const auto rigid = fit_film(along, FilmModel::kRigid, {.pixel_mm = 1 / 80.0});
  ASSERT_TRUE(rigid);
  EXPECT_EQ(rigid->redundancy, 1);
  EXPECT_LT((rigid->transformation.parameters - truth.parameters).norm(), 1e-6);
  EXPECT_FALSE(fit_film(along, FilmModel::kSimilarity, {}));
  EXPECT_FALSE(fit_film(across, FilmModel::kRigid, {.pixel_mm = 1 / 80.0}));
  EXPECT_FALSE(fit_film(across, FilmModel::kSimilarity, {}));
  EXPECT_FALSE(fit_film(along, FilmModel::kAffine, {}));
}

// One that is misread across its line is named, whatever it does along it.
TEST(FilmFit, AMisreadMarkOfOneCoordinateIsNamed) {
  int named = 0, others = 0;
  for (std::uint64_t trial = 1; trial <= 100; ++trial) {
    Random random(trial, 8);
    const FilmTransformation truth = example(FilmModel::kAffine);
    auto marks = side_marks_of_one(truth, 0.2, random);
    marks[5].pixel += 6 * truth.by_film(marks[5].film_mm).col(0).normalized();
    const auto fit = fit_film(marks, FilmModel::kAffine, {.sigmas_are_known = true});
    ASSERT_TRUE(fit);
    for (std::size_t i = 0; i < 8; ++i) (i == 5 ? named : others) += !fit->marks[i].is_used;
  }
  // 6 px are at least 15 sigmas of its residual: beyond the limit always. Others: the level is 0.001 a scan.
  EXPECT_EQ(named, 100);
  EXPECT_LE(others, 2);
}

}  // namespace
}  // namespace collinea
