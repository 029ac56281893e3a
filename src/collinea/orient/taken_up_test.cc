// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/orient/adjustment.h"
#include "collinea/quality/test_flight.h"

namespace collinea {
namespace {

using testing::FlightOptions;
using testing::Flown;
using testing::flown;
using testing::looking_for_systematics;
using testing::Wrong;

// With one camera, which is calibrated or given.
Adjustment adjusted(const Flown& made, const AdjustmentOptions& asked = {}, bool calibrate = true) {
  const Calibration calibration = calibrate ? Calibration::kBrown : Calibration::kNone;
  AdjustmentTask task{.block = made.block, .scope = made.scope, .options = looking_for_systematics(made, calibration)};
  task.block.cameras.at({1}).prior.calibrate = calibrate;
  auto done = adjust_block(std::move(task), asked, Run());
  EXPECT_TRUE(done) << done.error().message;
  return done ? std::move(*done) : Adjustment{};
}

double rms_error_m(const Adjustment& done, const Flown& made) {
  double sum = 0;
  for (const auto& [id, point] : done.block.points)
    sum += (point.position_in_world - made.truth.points.at(id).position_in_world).squaredNorm();
  return std::sqrt(sum / static_cast<double>(done.block.points.size()));
}

constexpr FlightOptions kTurned{.points = 300, .rotation_rad = 1.6};
const Wrong kAffine{.b1_px = 4, .b2_px = -3};

TEST(TakenUp, AnAffinityIsEstimatedWhereTheBlockDeterminesIt) {
  const Flown made = flown(1, kAffine, kTurned);
  const Adjustment done = adjusted(made);
  ASSERT_EQ(done.taken_up.size(), 1);
  EXPECT_EQ(done.taken_up[0].code, FindingCode::kSystematicTakenUp);
  EXPECT_EQ(done.taken_up[0].subjects.at(0), Subject(CameraId{1}, Aspect::kAffinity));
  const Camera& camera = done.block.cameras.at({1});
  const MatrixPd& covariance = done.adjusted.camera_covariance.at({1});
  EXPECT_NEAR(camera.params[Camera::kB1], 4, 4 * std::sqrt(covariance(Camera::kB1, Camera::kB1)));
  EXPECT_NEAR(camera.params[Camera::kB2], -3, 4 * std::sqrt(covariance(Camera::kB2, Camera::kB2)));
  EXPECT_GT(covariance(Camera::kB1, Camera::kB1), 0);
  for (const SystematicTest& test : done.adjusted.systematics) EXPECT_FALSE(test.significant) << word_of(test.kind);
  const Adjustment named = adjusted(made, {.systematics = Systematics::kName});
  EXPECT_TRUE(named.taken_up.empty());
  EXPECT_EQ(named.block.cameras.at({1}).params[Camera::kB1], 0);
  EXPECT_LT(rms_error_m(done, made), 0.8 * rms_error_m(named, made));
}

TEST(TakenUp, AdditionalParametersAreEstimatedWhereTheBlockDeterminesThem) {
  const Flown made = flown(1, {.additional = AdditionalSet::kFourier, .additional_px = 0.8}, kTurned);
  const Adjustment done = adjusted(made);
  ASSERT_EQ(done.taken_up.size(), 1);
  const Camera& camera = done.block.cameras.at({1});
  ASSERT_EQ(camera.additional, AdditionalSet::kFourier);
  EXPECT_NEAR(camera.params[Camera::kParams + count_of(AdditionalSet::kFourier) - 1], 0.8, 0.1);
  ASSERT_EQ(done.additional.size(), 1);
  EXPECT_TRUE(done.additional[0].parameters.back().significant);
  EXPECT_LT(rms_error_m(done, made), rms_error_m(adjusted(made, {.systematics = Systematics::kName}), made));
}

// Parallel strips: only what else is known of the block tells an affinity of the camera from one of the ground.
TEST(TakenUp, WhatTheBlockHardlyDeterminesIsOnlyNamed) {
  FlightOptions parallel = kTurned;
  parallel.rotation_rad = 3.1;
  const Adjustment done = adjusted(flown(1, kAffine, parallel));
  EXPECT_TRUE(done.taken_up.empty());
  EXPECT_TRUE(std::ranges::any_of(done.adjusted.systematics, &SystematicTest::significant));
}

TEST(TakenUp, CamerasKeepWhatTheyAreSaidToHave) {
  const Flown made = flown(1, kAffine, kTurned);
  EXPECT_TRUE(adjusted(made, {.calibration = Calibration::kBrown}).taken_up.empty());
  EXPECT_TRUE(adjusted(made, {.additional = AdditionalSet::kNone}).taken_up.empty());
  const Adjustment given = adjusted(made, {}, false);
  EXPECT_TRUE(given.taken_up.empty());
  EXPECT_EQ(given.block.cameras.at({1}).params, made.block.cameras.at({1}).params);
}

TEST(TakenUp, NothingInAGoodFlight) { EXPECT_TRUE(adjusted(flown(1, {}, kTurned)).taken_up.empty()); }

}  // namespace
}  // namespace collinea
