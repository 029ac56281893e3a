// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/additional_choice.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/math/fisher.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

// Of printed tables.
TEST(Fisher, TailsAreThoseOfTheTables) {
  EXPECT_NEAR(fisher_tail(3.70826, 3, 10), 0.05, 1e-6);
  EXPECT_NEAR(fisher_tail(6.55232, 3, 10), 0.01, 1e-6);
  EXPECT_NEAR(student_tail(2.228139, 10), 0.05, 1e-7);
  EXPECT_NEAR(student_tail(-3.169273, 10), 0.01, 1e-7);
  EXPECT_NEAR(student_tail(12.7062, 1), 0.05, 1e-6);
  EXPECT_NEAR(fisher_tail(3.841459, 1, INFINITY), 0.05, 1e-7);
  EXPECT_NEAR(fisher_tail(21.02607 / 12, 12, INFINITY), 0.05, 1e-7);
  EXPECT_NEAR(fisher_tail(1.4, 44, 1e7), fisher_tail(1.4, 44, INFINITY), 1e-5);
  EXPECT_EQ(fisher_tail(0, 3, 10), 1);
  EXPECT_TRUE(std::isnan(fisher_tail(NAN, 3, 10)));
}

// Two degrees of freedom have tails in closed form.
TEST(Fisher, LogarithmsOfTailsGoOnWhereTheseAreTooSmall) {
  for (const double value : {0.5, 3.0, 400.0, 5000.0}) {
    EXPECT_NEAR(log_fisher_tail(value, 2, INFINITY), -value, 1e-9 * value);
    EXPECT_NEAR(log_fisher_tail(value, 2, 500), -250 * std::log1p(value / 250), 1e-8 * value);
  }
  EXPECT_NEAR(log_fisher_tail(6.55232, 3, 10), std::log(0.01), 1e-4);
  EXPECT_EQ(log_fisher_tail(0, 3, 10), 0);
}

// As flown with film: no lens distortion, camera known, control well spread.
Block film_block(AdditionalSet set, const std::vector<std::pair<int, double>>& values_px, double sigma_px,
                 std::uint64_t seed) {
  Block block = test_block({.rows = 3, .columns = 4, .points = 220, .control = 14, .tilt_rad = 0.1, .seed = seed});
  Camera& camera = block.cameras.begin()->second;
  camera.params = ideal_camera(1500, camera.width_px, camera.height_px).params;
  camera.additional = set;
  for (const auto& [number, value] : values_px) camera.params[std::size_t(Camera::kParams + number - 1)] = value;
  Random random(seed, 3);
  const auto measure = [&](ImageId image, const Eigen::Vector3d& point) {
    const double du = random.normal(), dv = random.normal();
    return Eigen::Vector2d(*project(camera, pose_of(block, image) * point) + sigma_px * Eigen::Vector2d(du, dv));
  };
  for (Observation& o : block.observations) {
    o.pixel = measure(o.image, block.points.at(o.point).position_in_world);
    o.sigma_px = sigma_px;
  }
  for (ControlObservation& o : block.control_observations) {
    o.pixel = measure(o.image, block.control.at(o.point).position_in_world);
    o.sigma_px = sigma_px;
  }
  for (auto& [id, point] : block.control) {
    point.role = ControlRole::kControl;
    point.sigma_m.setZero();
  }
  return block;
}

ExamineOptions plain() {
  ExamineOptions options;
  options.adjust.calibration = Calibration::kNone;
  options.adjust.loss = options.adjust.position_loss = Loss::kNone;
  options.adjust.relative_cost_change = 1e-12;
  options.adjust.step_sigmas = 1e-6;
  return options;
}

Result<Examined> adjusted_of(Block block, const std::vector<std::string>& fixed = {}) {
  Camera& camera = block.cameras.begin()->second;
  std::fill(camera.params.begin() + Camera::kParams, camera.params.end(), 0.0);
  AdjustScope scope{.first_cameras = block.cameras};
  scope.camera_sigmas[block.cameras.begin()->first] = *with_additional({}, camera, fixed);
  return examine(block, scope, plain(), {});
}

class Additional : public ::testing::TestWithParam<AdditionalSet> {};

INSTANTIATE_TEST_SUITE_P(Sets, Additional,
                         ::testing::Values(AdditionalSet::kPolynomial, AdditionalSet::kEbner, AdditionalSet::kGruen,
                                           AdditionalSet::kFourier),
                         [](const auto& tested) { return std::string(kAdditionalNames[std::size_t(tested.param)]); });

// A film that shrank and bent by pixels comes back as far as its standard deviations say.
TEST_P(Additional, DeformationsAreRecovered) {
  std::vector<std::pair<int, double>> values;
  Random random(8);
  for (int k = 1; k <= int(count_of(GetParam())); ++k) values.emplace_back(k, random.uniform(-3, 3));
  const Block block = film_block(GetParam(), values, 1e-3, 4);
  const auto adjusted = adjusted_of(block);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  const MatrixPd& covariance = adjusted->camera_covariance.begin()->second;
  ASSERT_EQ(covariance.rows(), Camera::kParams + Eigen::Index(count_of(GetParam())));
  for (const auto& [number, value] : values) {
    const int k = Camera::kParams + number - 1;
    const double sigma_px = std::sqrt(covariance(k, k));
    EXPECT_LT(sigma_px, 0.01);
    EXPECT_NEAR(adjusted->cameras.begin()->second.params[std::size_t(k)], value, 5 * sigma_px + 1e-6) << number;
  }
  EXPECT_NEAR(adjusted->sigma0, 1, 4 / std::sqrt(2.0 * double(adjusted->redundancy)));
  const auto tests = test_additional(block, *adjusted, false, 0.01);
  ASSERT_EQ(tests.size(), 1u);
  EXPECT_LT(tests[0].chance, 1e-12);
  EXPECT_GT(tests[0].kept, int(0.9 * double(values.size())));
}

// Parameters that are zero are called significant as often as the level says: of n blocks the share of parameters has
// the level for its mean, its spread is taken from the blocks themselves; the F-test is binomial over the blocks.
TEST(AdditionalChoice, FalseSignificanceIsAsStated) {
  constexpr int kBlocks = 80;
  constexpr double kLevel = 0.05;
  double share = 0, share2 = 0;
  int false_sets = 0;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const Block block = film_block(AdditionalSet::kEbner, {}, 0.5, seed);
    const auto adjusted = adjusted_of(block);
    ASSERT_TRUE(adjusted);
    const auto tests = test_additional(block, *adjusted, seed % 2 == 0, kLevel);
    ASSERT_EQ(tests.size(), 1u);
    const auto significant = std::ranges::count_if(tests[0].parameters, &AdditionalParameter::significant);
    const double part = double(significant) / double(tests[0].parameters.size());
    share += part / kBlocks;
    share2 += part * part / kBlocks;
    false_sets += tests[0].chance < kLevel;
  }
  EXPECT_NEAR(share, kLevel, 4 * std::sqrt((share2 - share * share) / kBlocks));
  EXPECT_LT(4 * std::sqrt((share2 - share * share) / kBlocks), kLevel);
  EXPECT_NEAR(false_sets, kBlocks * kLevel, 4 * std::sqrt(kBlocks * kLevel * (1 - kLevel)));
}

// Of twelve three are there: those are kept, the others proposed to go, and what the kept ones would be without the
// others is what an adjustment without them finds.
TEST(AdditionalChoice, WhatIsNotThereIsProposedToGo) {
  const Block block = film_block(AdditionalSet::kEbner, {{2, 0.8}, {5, -1}, {9, 1.2}}, 0.4, 11);
  const auto adjusted = adjusted_of(block);
  ASSERT_TRUE(adjusted);
  const AdditionalTest test = test_additional(block, *adjusted, false, 0.001).at(0);
  EXPECT_EQ(test.kept, 3);
  std::vector<std::string> fixed;
  for (const AdditionalParameter& one : test.parameters) {
    const int number = one.param - Camera::kParams + 1;
    EXPECT_EQ(one.keep, number == 2 || number == 5 || number == 9) << number;
    if (!one.keep) fixed.push_back(param_name(one.param));
  }
  EXPECT_GT(test.dropped_chance, 1e-3);
  const auto without = adjusted_of(block, fixed);
  ASSERT_TRUE(without);
  const AdditionalTest again = test_additional(block, *without, false, 0.001).at(0);
  EXPECT_EQ(again.parameters.size(), 3u);
  EXPECT_EQ(again.kept, 3);
  EXPECT_EQ(again.dropped_chance, 1);
}

// The covariance of cameras against the inverse of normal equations whose derivatives are numeric: control is fixed, so
// poses and the camera are the only unknowns.
TEST(AdditionalChoice, CorrelationsAreThoseOfNumericDerivatives) {
  Block block = film_block(AdditionalSet::kGruen, {{1, 2}, {7, -1}}, 0.5, 21);
  block.observations.clear();
  block.points.clear();
  block = [&] {  // many more control points: 44 parameters want them
    Random random(2);
    const Camera& camera = block.cameras.begin()->second;
    for (std::uint32_t i = 100; i < 500; ++i) {
      ControlPoint point;
      point.name = std::to_string(i);
      point.position_in_world = testing::ground({}, random);
      point.sigma_m.setZero();
      block.control[{i}] = point;
      for (const auto& [image, pose] : oriented_images(block)) {
        const auto pixel = project(camera, pose * point.position_in_world);
        if (pixel && inside(camera, *pixel)) block.control_observations.push_back({{i}, image, *pixel, 0.5});
      }
    }
    return block;
  }();
  Camera camera = block.cameras.begin()->second;
  const CameraId id = block.cameras.begin()->first;
  AdjustScope scope{.first_cameras = block.cameras};
  scope.camera_sigmas[id] = *with_additional(calibration_sigmas(Calibration::kFocal, camera), camera, {});
  const auto adjusted = examine(block, scope, plain(), {});
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  camera = adjusted->cameras.at(id);

  const CameraSigmas& sigmas = scope.camera_sigmas[id];
  std::vector<int> free;
  for (const int k : params_of(camera))
    if (sigmas[std::size_t(k)] > 0) free.push_back(k);
  const auto n = 6 * Eigen::Index(adjusted->cam_from_world.size()) + Eigen::Index(free.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  for (const ControlObservation& seen : block.control_observations) {
    const auto pose = adjusted->cam_from_world.find(seen.image);
    const Eigen::Vector3d point = block.control.at(seen.point).position_in_world;
    const auto at = 6 * Eigen::Index(std::distance(adjusted->cam_from_world.begin(), pose));
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(2, n);
    const auto numeric = [&](Eigen::Index column, double step, const auto& pixel) {
      row.col(column) = (pixel(step) - pixel(-step)) / (2 * step) / seen.sigma_px;
    };
    for (int k = 0; k < 6; ++k)
      numeric(at + k, 1e-6, [&](double step) -> Eigen::Vector2d {
        const Eigen::Vector3d e = step * Eigen::Vector3d::Unit(k % 3);
        const Eigen::Vector3d in_cam = pose->second * point;
        return *project(camera, k < 3 ? rotation_by(e) * in_cam : in_cam + e);
      });
    for (std::size_t k = 0; k < free.size(); ++k)
      numeric(n - Eigen::Index(free.size()) + Eigen::Index(k), 1e-3, [&](double step) -> Eigen::Vector2d {
        Camera moved = camera;
        moved.params[std::size_t(free[k])] += step;
        return *project(moved, pose->second * point);
      });
    normal += row.transpose() * row;
  }
  for (std::size_t k = 0; k < free.size(); ++k) {
    const auto i = n - Eigen::Index(free.size()) + Eigen::Index(k);
    normal(i, i) += 1 / (sigmas[std::size_t(free[k])] * sigmas[std::size_t(free[k])]);
  }
  const Eigen::MatrixXd covariance =
      normal.inverse().bottomRightCorner(Eigen::Index(free.size()), Eigen::Index(free.size()));
  const MatrixPd ours = adjusted->camera_covariance.at(id)(free, free);
  for (Eigen::Index a = 0; a < covariance.rows(); ++a)
    for (Eigen::Index b = 0; b < covariance.rows(); ++b)
      EXPECT_NEAR(ours(a, b) / std::sqrt(ours(a, a) * ours(b, b)),
                  covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b)), 1e-5);

  const auto tests = test_additional(block, *adjusted, false, 0.01);
  ASSERT_EQ(tests.size(), 1u);
  for (const AdditionalParameter& one : tests[0].parameters) {
    const auto i = std::ranges::find(free, one.param) - free.begin();
    double largest = 0;
    for (Eigen::Index b = 0; b < covariance.rows(); ++b)
      if (b != i)
        largest = std::max(largest, std::abs(covariance(i, b)) / std::sqrt(covariance(i, i) * covariance(b, b)));
    EXPECT_NEAR(std::abs(one.correlation), largest, 1e-5);
    EXPECT_GE(one.multiple_correlation, largest - 1e-6);
    EXPECT_LE(one.multiple_correlation, 1);
  }
}

TEST(AdditionalChoice, WhatTheSetSpansIsFixed) {
  Camera camera = testing::test_camera();
  const CameraSigmas brown = calibration_sigmas(Calibration::kBrownAffinity, camera);
  camera.additional = AdditionalSet::kEbner;
  const CameraSigmas ebner = *with_additional(brown, camera, {"a3"});
  for (const char* name : {"b1", "b2", "p1", "p2", "a3"})
    EXPECT_EQ(ebner[std::size_t(*param_named(camera, name))], 0) << name;
  EXPECT_GT(ebner[Camera::kK1], 0);
  EXPECT_GT(ebner[Camera::kParams + 11], 0);
  EXPECT_FALSE(with_additional(brown, camera, {"a13"}));
  EXPECT_FALSE(with_additional(brown, camera, {"k1"}));
  camera.additional = AdditionalSet::kGruen;
  EXPECT_EQ((*with_additional(brown, camera, {}))[Camera::kK1], 0);
}

}  // namespace
}  // namespace collinea
