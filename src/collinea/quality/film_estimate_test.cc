// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/film_estimate.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/adjust/test_block.h"
#include "collinea/quality/internal/test_examine.h"
#include "collinea/quality/marked_points.h"

namespace collinea {
namespace {

using testing::TestBlockOptions;

const Run kRun;

// Scans of film, each deformed by chance as its prior says. `truth`: the functions of each.
struct Scanned {
  Block block;
  AdjustScope scope;
  std::map<CameraId, std::array<double, Camera::kAllParams>> truth;
  std::map<ControlId, Eigen::Vector3d> check;  ///< exact
};

Scanned scanned(std::uint64_t seed, double sigma_px, double correlation_px, int functions, int points = 150) {
  const double noise_px = 0.3;
  Scanned made;
  made.block = testing::test_block({.rows = 2, .columns = 4, .points = points, .control = 12, .seed = seed});
  Random random(seed, 31);
  const Camera lens = made.block.cameras.begin()->second;
  made.block.cameras.clear();
  for (auto& [id, image] : made.block.images) {
    image.camera = CameraId{id.value};
    Camera& camera = made.block.cameras[image.camera] = lens;
    camera.prior.calibrate = false;
    camera.additional = AdditionalSet::kFilm;
    camera.prior.film = FilmPrior{.sigma_px = sigma_px, .correlation_px = correlation_px, .functions = functions};
    const ImageExtent size{double(camera.width_px), double(camera.height_px)};
    const FilmField field = film_field(*camera.prior.film, film_shape(*camera.prior.film, size, correlation_px));
    const Eigen::MatrixXd root = field.covariance.llt().matrixL();
    for (const std::size_t axis : {0u, 1u}) {
      Eigen::VectorXd values(functions);
      for (double& value : values) value = random.normal();
      values = (root * values).eval();
      for (Eigen::Index k = 0; k < functions; ++k)
        camera.params[Camera::kParams + 2 * std::size_t(k) + axis] = values[k];
    }
    made.truth[image.camera] = camera.params;
  }
  const auto measure = [&](auto& seen, const Eigen::Vector3d& point) {
    const double dx = random.normal(), dy = random.normal();
    seen.pixel = *project(made.block.camera_of(seen.image), pose_of(made.block, seen.image) * point) +
                 noise_px * Eigen::Vector2d(dx, dy);
    seen.sigma_px = noise_px;
  };
  for (Observation& seen : made.block.observations) measure(seen, made.block.points.at(seen.point).position_in_world);
  for (ControlObservation& seen : made.block.control_observations)
    measure(seen, made.block.control.at(seen.point).position_in_world);
  for (auto& [id, control] : made.block.control) {
    made.check[id] = control.position_in_world;
    control.position_in_world += 0.01 * testing::normal3(random);
  }
  for (auto& [id, camera] : made.block.cameras)
    std::fill(camera.params.begin() + Camera::kParams, camera.params.end(), 0.0);
  return made;
}

// Chi-squared of one check point of a block, and its degrees of freedom: other points of it share its errors.
double square_of_check(const Scanned& made, const Adjusted& adjusted) {
  for (const ControlDifference& check : adjusted.control)
    if (!check.used && check.covariance_m2 && check.rays >= 2) {
      const Eigen::Vector3d error = *check.position_in_world - made.check.at(check.point);
      return error.dot(check.covariance_m2->inverse() * error);
    }
  return 0;
}

// What the adjustment says of the functions of an image and of a check point is what these are off: chi-squared of 20
// functions of an image (mean 20, standard deviation sqrt(40 / n) over n blocks) and of a point (3, sqrt(6 / n)). Taken
// as undeformed, the same blocks miss what they promise by far.
TEST(FilmEstimate, CovariancesTellTheTruthOfDeformedFilm) {
  constexpr int kBlocks = 25, kFunctions = 10;
  double functions = 0, checks = 0, undeformed = 0;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    Scanned made = scanned(seed, 0.8, 400, kFunctions, 100);
    const auto adjusted = examine(made.block, made.scope, testing::examined(), kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    const auto& [id, covariance] = *adjusted->camera_covariance.begin();
    Eigen::VectorXd error(2 * kFunctions);
    for (Eigen::Index k = 0; k < error.size(); ++k) {
      const auto param = std::size_t(Camera::kParams + k);
      error[k] = adjusted->cameras.at(id).params[param] - made.truth.at(id)[param];
    }
    functions += error.dot(
        covariance.block(Camera::kParams, Camera::kParams, 2 * kFunctions, 2 * kFunctions).llt().solve(error));
    checks += square_of_check(made, *adjusted);
    for (auto& [number, camera] : made.block.cameras) camera.additional = AdditionalSet::kNone;
    const auto without = examine(made.block, made.scope, testing::examined(), kRun);
    ASSERT_TRUE(without);
    undeformed += square_of_check(made, *without);
  }
  EXPECT_NEAR(functions / kBlocks, 20, 4 * std::sqrt(40.0 / kBlocks));
  EXPECT_NEAR(checks / kBlocks, 3, 4 * std::sqrt(6.0 / kBlocks));
  EXPECT_GT(undeformed / kBlocks, 3 + 8 * std::sqrt(6.0 / kBlocks));
}

// Of 8 scans with 2 x 10 functions each, that measurements determine well, logarithms of standard deviation and length
// are known to about sqrt(1 / (2 x 160)) = 0.06 each if nothing else was unknown, to twice that together; the mean of
// three blocks to 0.07, and iterations end within 0.02 a step: less than four of these.
TEST(FilmEstimate, FindsTheProcessFromFarOff) {
  constexpr int kBlocks = 3;
  double sigma = 0, length = 0;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    Scanned made = scanned(seed, 0.8, 400, 10, 200);
    for (auto& [id, camera] : made.block.cameras) {
      camera.prior.film->sigma_px = 0.4;
      camera.prior.film->correlation_px = 250;
    }
    const auto found = estimate_film(made.block, made.scope, testing::examined(), kRun);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(found->before.sigma_px, 0.4);
    EXPECT_GT(found->iterations, 0);
    sigma += std::log(found->process.sigma_px / 0.8) / kBlocks;
    length += std::log(found->process.correlation_px / 400) / kBlocks;
  }
  EXPECT_LT(std::abs(sigma), 4 * 0.07) << sigma;
  EXPECT_LT(std::abs(length), 4 * 0.07) << length;
}

TEST(FilmEstimate, WhatIsGivenStays) {
  Scanned made = scanned(3, 0.8, 400, 10);
  for (auto& [id, camera] : made.block.cameras)
    camera.prior.film->sigma_is_given = camera.prior.film->correlation_is_given = true;
  const auto found = estimate_film(made.block, made.scope, testing::examined(), kRun);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->process.sigma_px, 0.8);
  EXPECT_EQ(found->process.correlation_px, 400);
  EXPECT_EQ(found->iterations, 0);
}

// Control that is marked one by one in scans of film gives what the adjustment of everything with it gives: the
// unknowns of the deformation are among those that marks move. The block lies free without its control.
TEST(FilmEstimate, MarksInScansOfFilmAreAdjustedAsTogether) {
  const Scanned made = scanned(5, 0.8, 400, 10, 200);
  const auto together = examine(made.block, made.scope, testing::examined(), kRun);
  ASSERT_TRUE(together);
  auto base = MarkedBlock::of(made.block, made.scope, testing::plain(), BlockControl::kLeftOut, kRun);
  ASSERT_TRUE(base) << base.error().message;
  std::vector<BlockPoint> points;
  for (const auto& [id, control] : made.block.control) {
    BlockPoint& point = points.emplace_back();
    point.surveyed = SurveyedPosition{control.position_in_world, control.sigma_m, control.correlation, control.role};
    for (const ControlObservation& seen : made.block.control_observations)
      if (seen.point == id) point.marks.push_back({seen.image, seen.pixel, seen.sigma_px, seen.shape});
  }
  const auto marks = base->adjust(points);
  ASSERT_TRUE(marks) << marks.error().message;
  EXPECT_TRUE(marks->placed && marks->converged);
  std::size_t p = 0;
  for (const ControlDifference& control : together->control) {
    const AdjustedMark& mark = marks->points[p++];
    ASSERT_TRUE(mark.position_in_world && control.covariance_m2);
    const Eigen::Matrix3d covariance = mark.covariance_m2 / (marks->sigma0 * marks->sigma0);
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = std::sqrt((*control.covariance_m2)(axis, axis));
      EXPECT_NEAR((*mark.position_in_world)[axis], (*control.position_in_world)[axis], 0.01 * sigma);
      EXPECT_NEAR(std::sqrt(covariance(axis, axis)), sigma, 0.01 * sigma);
    }
  }
}

TEST(FilmEstimate, AsManyFunctionsAsTheNumberOfScansAllows) {
  Block block;
  for (std::uint32_t i = 0; i < 300; ++i) {
    Camera& camera = block.cameras[{i}] = testing::test_camera();
    if (i > 0) camera.prior.film = FilmPrior{.sigma_px = 1, .correlation_px = 100};
  }
  add_film(block);
  EXPECT_EQ(block.cameras.at({0}).additional, AdditionalSet::kNone);
  EXPECT_EQ(block.cameras.at({1}).prior.film->functions, 10);  // 299 x 2 x 15 would be more than 6000
  block.cameras.erase(block.cameras.find({20}), block.cameras.end());
  add_film(block);
  EXPECT_EQ(block.cameras.at({1}).prior.film->functions, 28);
}

}  // namespace
}  // namespace collinea
