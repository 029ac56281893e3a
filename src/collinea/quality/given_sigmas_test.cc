// SPDX-License-Identifier: Apache-2.0
// Control that is fixed, cameras whose parameters are free, weighted or fixed one by one, and lenses that correct
// measured coordinates.
#include <gtest/gtest.h>

#include <limits>

#include "collinea/quality/examine.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::disturbed;
using testing::test_block;

const Run kRun;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

ExamineOptions exact(Calibration calibration = Calibration::kNone) {
  ExamineOptions options;
  options.adjust.calibration = calibration;
  options.adjust.loss = options.adjust.position_loss = Loss::kNone;
  options.adjust.relative_cost_change = 1e-13;
  options.adjust.parameter_change = 1e-13;
  options.adjust.step_sigmas = 0;
  return options;
}

double largest_difference_m(const Examined& a, const Examined& b) {
  double largest = 0;
  for (const auto& [id, pose] : a.cam_from_world)
    largest = std::max(largest, (centre_of(pose) - centre_of(b.cam_from_world.at(id))).norm());
  return largest;
}

Block with_control_sigma(Block block, const Eigen::Vector3d& sigma_m) {
  for (auto& [id, control] : block.control) control.sigma_m = sigma_m;
  return block;
}

// Half a pixel is 2 cm on the ground: sigmas of 0.02 mm differ from no freedom by (0.02 / 20)^2, for each of some
// images.
TEST(FixedControl, IsTheLimitOfEverSmallerSigmas) {
  const Block block = test_block({.sigma_px = 0.5, .control = 12});
  const auto fixed = examine(with_control_sigma(block, {0, 0, 0}), {}, exact(), kRun);
  const auto stiff = examine(with_control_sigma(block, {2e-5, 2e-5, 2e-5}), {}, exact(), kRun);
  ASSERT_TRUE(fixed && stiff);
  EXPECT_EQ(fixed->redundancy, stiff->redundancy);
  EXPECT_EQ(fixed->unknown_count, stiff->unknown_count - 3 * 8);
  EXPECT_EQ(fixed->rank_defect, 0);
  EXPECT_NEAR(fixed->sigma0, stiff->sigma0, 1e-4);
  EXPECT_LT(largest_difference_m(*fixed, *stiff), 1e-4);
  for (const auto& [id, covariance] : fixed->pose_covariance)
    EXPECT_NEAR(covariance(3, 3) / stiff->pose_covariance.at(id)(3, 3), 1, 1e-4);
  for (const ControlDifference& control : fixed->control) {
    if (control.used) {
      EXPECT_EQ(control.difference_m, Eigen::Vector3d::Zero());
    }
  }
}

TEST(FixedControl, HoldsSingleAxes) {
  const Block block = test_block({.sigma_px = 0.5, .control = 12});
  const auto fixed = examine(with_control_sigma(block, {0, 0, 0.02}), {}, exact(), kRun);
  const auto stiff = examine(with_control_sigma(block, {2e-5, 2e-5, 0.02}), {}, exact(), kRun);
  ASSERT_TRUE(fixed && stiff);
  EXPECT_EQ(fixed->redundancy, stiff->redundancy);
  EXPECT_LT(largest_difference_m(*fixed, *stiff), 1e-4);
  for (const ControlDifference& control : fixed->control) {
    if (!control.used) continue;
    EXPECT_LT(control.difference_m.head<2>().norm(), 1e-5);
    EXPECT_GT(std::abs(control.difference_m.z()), 1e-6);
  }
}

TEST(FixedControl, IsTestedAndReportedWithoutHarm) {
  Block block = with_control_sigma(test_block({.sigma_px = 0.5, .control = 12}), {0, 0, 0});
  ExamineOptions options = exact();
  options.reliability = options.point_covariances = true;
  const auto adjusted = examine(block, {}, options, kRun);
  ASSERT_TRUE(adjusted && adjusted->reliability);
  // Redundancies add up to the redundancy, fixed points or not.
  double sum = 0;
  for (const GroupSums& group : adjusted->reliability->groups) sum += group.redundancy;
  EXPECT_NEAR(sum, double(adjusted->redundancy), 1e-6 * double(adjusted->redundancy));
}

TEST(CameraSigmas, OfANamedSetAreThatSet) {
  const Block block = disturbed(test_block({.sigma_px = 0.5, .control = 9}), 0.005, 0.3);
  AdjustScope scope{.first_cameras = block.cameras};
  const auto named = examine(block, scope, exact(Calibration::kBrown), kRun);
  scope.camera_sigmas[{1}] = calibration_sigmas(Calibration::kBrown, block.cameras.at({1}));
  const auto given = examine(block, scope, exact(Calibration::kNone), kRun);
  ASSERT_TRUE(named && given);
  EXPECT_EQ(named->cameras.at({1}).params, given->cameras.at({1}).params);
  EXPECT_EQ(named->observation_count, given->observation_count);
}

// Free: no observation of the parameter. Weighted: one, which draws it to its value. Fixed: not moved.
TEST(CameraSigmas, EachParameterTakesPartAsItIsAsked) {
  const Block block = test_block({.sigma_px = 0.5, .control = 9});
  AdjustScope scope{.first_cameras = block.cameras};
  scope.first_cameras.at({1}).params[Camera::kK1] += 0.1;
  const auto none = examine(block, scope, exact(Calibration::kNone), kRun);
  CameraSigmas& sigmas = scope.camera_sigmas[{1}];
  sigmas.fill(0);
  sigmas[Camera::kF] = kInfinity;
  const auto free = examine(block, scope, exact(Calibration::kNone), kRun);
  ASSERT_TRUE(none && free);
  EXPECT_EQ(free->redundancy, none->redundancy - 1);
  EXPECT_EQ(free->observation_count, none->observation_count);
  EXPECT_NE(free->cameras.at({1}).params[Camera::kF], block.cameras.at({1}).params[Camera::kF]);
  EXPECT_EQ(free->cameras.at({1}).params[Camera::kK1], block.cameras.at({1}).params[Camera::kK1]);
  sigmas[Camera::kK1] = 1e-6;
  const auto weighted = examine(block, scope, exact(Calibration::kNone), kRun);
  ASSERT_TRUE(weighted);
  EXPECT_EQ(weighted->redundancy, free->redundancy);
  EXPECT_EQ(weighted->observation_count, free->observation_count + 1);
  EXPECT_NEAR(weighted->cameras.at({1}).params[Camera::kK1], block.cameras.at({1}).params[Camera::kK1] + 0.1, 1e-4);
  sigmas[Camera::kK1] = -1;
  const auto wrong = examine(block, scope, exact(Calibration::kNone), kRun);
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, Errc::kBadInput);
}

// The same world seen through a lens whose polynomial corrects what was measured.
Block of_measured(const testing::TestBlockOptions& o) {
  Block block = test_block(o);
  Camera& camera = block.cameras.at({1});
  camera.model = BrownOfMeasured{};
  camera.params[Camera::kK1] = 0.12;
  camera.params[Camera::kB1] = 1.5;
  Random random(12);
  const auto measure = [&](ImageId image, const Eigen::Vector3d& position, Eigen::Vector2d& pixel) {
    const auto seen = project(camera, pose_of(block, image) * position);
    ASSERT_TRUE(seen);
    const double du = random.normal(), dv = random.normal();
    pixel = *seen + o.sigma_px * Eigen::Vector2d(du, dv);
  };
  for (Observation& seen : block.observations)
    measure(seen.image, block.points.at(seen.point).position_in_world, seen.pixel);
  for (ControlObservation& seen : block.control_observations)
    measure(seen.image, block.control.at(seen.point).position_in_world, seen.pixel);
  return with_control_sigma(block, {0, 0, 0});
}

TEST(MeasuredLens, IsCalibratedFromNothing) {
  const Block truth = of_measured({.control = 15});
  for (const bool after_correction : {false, true}) {
    Block start = disturbed(truth, 0.005, 0.3);
    Camera& camera = start.cameras.at({1});
    camera.params = ideal_camera(1510, camera.width_px, camera.height_px).params;
    AdjustScope scope;
    scope.camera_sigmas[{1}].fill(kInfinity);
    if (after_correction) scope.corrected_cameras.insert({1});
    const auto adjusted = examine(start, scope, exact(), kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    EXPECT_TRUE(adjusted->converged);
    for (std::size_t k = 0; k < Camera::kParams; ++k)
      EXPECT_NEAR(adjusted->cameras.at({1}).params[k], truth.cameras.at({1}).params[k],
                  1e-6 * std::max(1.0, std::abs(truth.cameras.at({1}).params[k])))
          << Camera::kParamNames[k];
  }
}

// Errors are of what was measured: taken there sigma0 is 1 within four of its standard deviations; taken after the
// correction, which stretches this lens' corners by some per cent, it is not.
TEST(MeasuredLens, SigmasHoldWhereTheyAreSaidTo) {
  Block block = of_measured({.points = 1500, .sigma_px = 0.5, .control = 15});
  AdjustScope scope;
  scope.camera_sigmas[{1}].fill(kInfinity);
  const auto measured = examine(block, scope, exact(), kRun);
  scope.corrected_cameras.insert({1});
  const auto corrected = examine(block, scope, exact(), kRun);
  ASSERT_TRUE(measured && corrected);
  const double bound = 4 / std::sqrt(2.0 * double(measured->redundancy));
  EXPECT_NEAR(measured->sigma0, 1, bound);
  EXPECT_GT(corrected->sigma0, 1 + bound);
}

}  // namespace
}  // namespace collinea
