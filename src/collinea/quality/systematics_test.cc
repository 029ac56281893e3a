// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/systematics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/geodesy/refraction.h"
#include "collinea/quality/additional_choice.h"
#include "collinea/quality/test_flight.h"

namespace collinea {
namespace {

using testing::FlightOptions;
using testing::Flown;
using testing::flown;
using testing::looking_for_systematics;
using testing::Wrong;

const Run kRun;
const Eigen::Vector3d kNotKnown = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
constexpr FlightOptions kExact{.noise = false};

std::vector<SystematicTest> tests_of(const Flown& made, const ExamineOptions& options, const Run& run = kRun) {
  const auto examined = examine(made.block, made.scope, options, run);
  EXPECT_TRUE(examined) << examined.error().message;
  return examined ? examined->systematics : std::vector<SystematicTest>{};
}

std::vector<SystematicTest> tests_of(const Flown& made) { return tests_of(made, looking_for_systematics(made)); }

const SystematicTest* of_kind(const std::vector<SystematicTest>& tests, SystematicKind kind, int strip = -1,
                              AdditionalSet set = AdditionalSet::kNone) {
  const auto its = std::ranges::find_if(tests, [&](const SystematicTest& test) {
    return test.kind == kind && test.strip.value_or(-1) == strip && test.additional == set;
  });
  return its == tests.end() ? nullptr : &*its;
}

// Kinds of the significant ones that stand for themselves, the strongest first.
std::vector<SystematicKind> named_in(std::vector<SystematicTest> tests) {
  std::erase_if(tests, [](const SystematicTest& test) { return !test.significant || test.explained_by; });
  std::ranges::stable_sort(tests, is_stronger);
  std::vector<SystematicKind> kinds;
  for (const SystematicTest& test : tests) kinds.push_back(test.kind);
  return kinds;
}

// The estimate of a small error without noise is the error: the derivatives are right.
void expect_found(const Wrong& wrong, SystematicKind kind, const std::vector<double>& values, double relative,
                  int strip = -1, const FlightOptions& options = kExact) {
  const std::vector<SystematicTest> tests = tests_of(flown(1, wrong, options));
  const SystematicTest* test = of_kind(tests, kind, strip);
  ASSERT_TRUE(test) << word_of(kind);
  EXPECT_TRUE(test->determined) << word_of(kind);
  ASSERT_EQ(test->values.size(), values.size());
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  for (std::size_t k = 0; k < values.size(); ++k)
    EXPECT_NEAR(test->values[k], values[k], relative * largest) << word_of(kind) << " " << k;
}

TEST(Systematics, ExactErrorsOfPositionsAreFoundAsTheyAre) {
  expect_found({.time_offset_s = 0.01}, SystematicKind::kTimeOffset, {0.01}, 1e-3);
  expect_found({.lever_arm_m = {0.02, -0.01, 0.03}}, SystematicKind::kLeverArm, {0.02, -0.01, 0.03}, 1e-3);
  expect_found({.shift_m = {0.02, -0.01, 0.03}}, SystematicKind::kShift, {0.02, -0.01, 0.03}, 1e-3);
  expect_found({.shift_m = {0.02, -0.01, 0.03}, .strip = 2}, SystematicKind::kShift, {0.02, -0.01, 0.03}, 1e-3, 2);
  expect_found({.drift_m = {0.02, -0.01, 0.03}}, SystematicKind::kDrift, {0.02, -0.01, 0.03}, 1e-3);
  expect_found({.shift_m = {0, 0, 0.03}}, SystematicKind::kVerticalDatum, {0.03}, 1e-3);
  FlightOptions coarse = kExact;  // no receiver that bends the block by metres
  coarse.position_sigma_m = 1;
  expect_found({.assignment = 1}, SystematicKind::kAssignment, {1}, 0.05, -1, coarse);
  expect_found({.assignment = -1}, SystematicKind::kAssignment, {-1}, 0.05, -1, coarse);
}

TEST(Systematics, ExactErrorsOfAttitudesAndHeightsAreFoundAsTheyAre) {
  FlightOptions attitudes = kExact;
  attitudes.attitudes = true;
  expect_found({.boresight_rad = {1e-3, -5e-4, 7e-4}}, SystematicKind::kBoresight, {1e-3, -5e-4, 7e-4}, 1e-2, -1,
               attitudes);
  FlightOptions without_control = kExact;
  without_control.control = 0;
  expect_found({.bowl_m = 0.02}, SystematicKind::kBowl, {0.02}, 1e-2, -1, without_control);
}

TEST(Systematics, ExactErrorsOfImagesAreFoundAsTheyAre) {
  expect_found({.b1_px = 0.2, .b2_px = -0.1}, SystematicKind::kAffinity, {0.2, -0.1}, 1e-2);
  expect_found({.shutter_s = 0.002}, SystematicKind::kRollingShutter, {0.002}, 1e-2);
  const double raise = refraction_rad(400, 340) / 60;  // the heights of the flight, nearly
  expect_found({.refraction = 100}, SystematicKind::kRefraction, {100 * 2e-8 / raise}, 0.05);
}

TEST(Systematics, AdditionalSetsAreFoundAsTheyAre) {
  for (const AdditionalSet set :
       {AdditionalSet::kPolynomial, AdditionalSet::kEbner, AdditionalSet::kGruen, AdditionalSet::kFourier}) {
    const std::vector<SystematicTest> tests = tests_of(flown(1, {.additional = set, .additional_px = 0.1}, kExact));
    const SystematicTest* test = of_kind(tests, SystematicKind::kAdditional, -1, set);
    ASSERT_TRUE(test) << word_of(set);
    ASSERT_EQ(test->values.size(), count_of(set));
    EXPECT_NEAR(test->values.back(), 0.1, 0.01) << word_of(set);
    EXPECT_NEAR(test->largest_effect, 0.1, 0.1);
  }
}

// What adjusting again with the parameter free gives: the estimate, and by how much the squares become less.
void expect_as_adjusted(const SystematicTest& test, const std::vector<double>& estimate, double less) {
  for (std::size_t k = 0; k < estimate.size(); ++k) EXPECT_NEAR(test.values[k], estimate[k], 0.1 * test.sigmas[k]);
  EXPECT_NEAR(test.statistic, less, 0.02 * less + 0.05) << word_of(test.kind);
}

std::vector<double> auxiliaries_of(const Adjusted& adjusted, UnknownKind kind) {
  std::vector<double> values;
  for (const EstimatedUnknown& one : adjusted.auxiliaries)
    if (one.kind == kind) values.push_back(one.value);
  return values;
}

TEST(Systematics, ScoresAgreeWithAdjustingAgain) {
  const FlightOptions flight{.attitudes = true};
  const Flown made = flown(3,
                           {.time_offset_s = 0.001,
                            .lever_arm_m = {0.004, 0.006, 0},
                            .shift_m = {0, 0.004, -0.006},
                            .boresight_rad = {3e-4, 0, 0},
                            .b1_px = 0.05},
                           flight);
  const ExamineOptions options = looking_for_systematics(made, Calibration::kBrown);
  const auto before = examine(made.block, made.scope, options, kRun);
  ASSERT_TRUE(before);
  const auto compare = [&](SystematicKind kind, const AdjustScope& scope, UnknownKind unknown) {
    const auto after = adjust(made.block, scope, options.adjust, kRun);
    ASSERT_TRUE(after) << after.error().message;
    expect_as_adjusted(*of_kind(before->systematics, kind), auxiliaries_of(*after, unknown),
                       before->final_cost - after->final_cost);
  };
  AdjustScope scope = made.scope;
  scope.time_offset_sigma_s[{1}] = kNotKnown[0];
  scope.velocity_m_s = made.systematics.velocity_m_s;
  compare(SystematicKind::kTimeOffset, scope, UnknownKind::kTimeOffset);
  scope = made.scope;
  scope.lever_arms[{1}] = {Eigen::Vector3d::Zero(), kNotKnown};
  compare(SystematicKind::kLeverArm, scope, UnknownKind::kLeverArm);
  scope = made.scope;
  PositionTrack track{.shift_sigma_m = kNotKnown};
  for (const auto& [id, image] : made.block.images) track.time[id] = 0;
  scope.position_tracks = {track};
  compare(SystematicKind::kShift, scope, UnknownKind::kShift);
  scope = made.scope;
  scope.boresight_sigma_rad[{1}] = kNotKnown;
  compare(SystematicKind::kBoresight, scope, UnknownKind::kBoresight);
  // Of images, by the unknowns of the camera.
  const SystematicTest& affinity = *of_kind(before->systematics, SystematicKind::kAffinity);
  const auto with_affinity = adjust(made.block, made.scope, testing::plain(Calibration::kBrownAffinity), kRun);
  ASSERT_TRUE(with_affinity);
  const auto& params = with_affinity->cameras.at({1}).params;
  expect_as_adjusted(affinity, {params[Camera::kB1], params[Camera::kB2]},
                     before->final_cost - with_affinity->final_cost);
}

// Points that are measured on the ground keep their unknowns.
TEST(Systematics, ScoresAgreeWithAdjustingAgainBesideMeasurementsOnTheGround) {
  Flown made = flown(13, {.time_offset_s = 0.001, .b1_px = 0.1});
  for (std::uint32_t i = 1; i < 6; ++i)
    made.block.geodetic.push_back(
        {.kind = GeodeticKind::kDistance,
         .from = {0},
         .to = {i},
         .value = (made.truth.control.at({0}).position_in_world - made.truth.control.at({i}).position_in_world).norm() +
                  0.004,
         .sigma = 0.005});
  const ExamineOptions options = looking_for_systematics(made, Calibration::kBrown);
  const auto before = examine(made.block, made.scope, options, kRun);
  ASSERT_TRUE(before) << before.error().message;
  AdjustScope scope = made.scope;
  scope.time_offset_sigma_s[{1}] = kNotKnown[0];
  scope.velocity_m_s = made.systematics.velocity_m_s;
  const auto with_offset = adjust(made.block, scope, options.adjust, kRun);
  const auto with_affinity = adjust(made.block, made.scope, testing::plain(Calibration::kBrownAffinity), kRun);
  ASSERT_TRUE(with_offset && with_affinity);
  expect_as_adjusted(*of_kind(before->systematics, SystematicKind::kTimeOffset),
                     auxiliaries_of(*with_offset, UnknownKind::kTimeOffset),
                     before->final_cost - with_offset->final_cost);
  const auto& params = with_affinity->cameras.at({1}).params;
  expect_as_adjusted(*of_kind(before->systematics, SystematicKind::kAffinity),
                     {params[Camera::kB1], params[Camera::kB2]}, before->final_cost - with_affinity->final_cost);
}

TEST(Systematics, ScoresOfAdditionalSetsAgreeWithAdjustingAgain) {
  const Flown made = flown(4, {.additional = AdditionalSet::kPolynomial, .additional_px = 0.1});
  const ExamineOptions options = looking_for_systematics(made);
  const auto before = examine(made.block, made.scope, options, kRun);
  ASSERT_TRUE(before);
  for (const AdditionalSet set : {AdditionalSet::kPolynomial, AdditionalSet::kEbner, AdditionalSet::kFourier}) {
    Block block = made.block;
    block.cameras.at({1}).additional = set;
    CameraSigmas sigmas{};
    for (std::size_t k = 0; k < count_of(set); ++k) sigmas[Camera::kParams + k] = kNotKnown[0];
    AdjustScope scope = made.scope;
    scope.camera_sigmas[{1}] = sigmas;
    const auto after = adjust(block, scope, options.adjust, kRun);
    ASSERT_TRUE(after) << after.error().message;
    const SystematicTest& test = *of_kind(before->systematics, SystematicKind::kAdditional, -1, set);
    const double less = before->final_cost - after->final_cost;
    EXPECT_EQ(test.degrees, static_cast<int>(count_of(set)));
    EXPECT_NEAR(test.statistic, less, 0.02 * less) << word_of(set);
    for (std::size_t k = 0; k < count_of(set); ++k)
      EXPECT_NEAR(test.values[k], after->cameras.at({1}).params[Camera::kParams + k], 0.1 * test.sigmas[k]);
  }
}

// Each statistic is chi-squared in blocks without systematic errors: its mean is its degrees of freedom q with the
// standard deviation sqrt(2 q / n). Four of these leave one false alarm in 16,000.
TEST(Systematics, StatisticsOfGoodBlocksAreChiSquared) {
  constexpr int kBlocks = 40;
  const FlightOptions flight{.strips = 3, .images = 5, .points = 80, .attitudes = true};
  std::vector<double> sums, degrees;
  int alarms = 0;
  for (int i = 0; i < kBlocks; ++i) {
    const std::vector<SystematicTest> tests = tests_of(flown(100 + static_cast<std::uint64_t>(i), {}, flight));
    sums.resize(tests.size());
    degrees.resize(tests.size());
    for (std::size_t k = 0; k < tests.size(); ++k) {
      if (tests[k].kind == SystematicKind::kAssignment) continue;  // one of two
      sums[k] += tests[k].statistic;
      degrees[k] += tests[k].degrees;
    }
    alarms += std::ranges::any_of(tests, &SystematicTest::significant);
  }
  for (std::size_t k = 0; k < sums.size(); ++k) EXPECT_NEAR(sums[k], degrees[k], 4 * std::sqrt(2 * degrees[k])) << k;
  EXPECT_LE(alarms, 1);
}

// Robust weights and estimated sigma0, image points twice as bad as stated.
TEST(Systematics, StatisticsHoldUnderLossesAndWithWrongSigmasOfImages) {
  constexpr int kBlocks = 40;
  double sum = 0, degrees = 0, errors = 0;
  for (int i = 0; i < kBlocks; ++i) {
    Flown made =
        flown(200 + static_cast<std::uint64_t>(i), {.time_offset_s = 0.01}, {.strips = 3, .images = 5, .points = 80});
    for (Observation& seen : made.block.observations) seen.sigma_px /= 2;
    for (ControlObservation& seen : made.block.control_observations) seen.sigma_px /= 2;
    ExamineOptions options = looking_for_systematics(made);
    options.adjust.loss = options.adjust.position_loss = Loss::kHuber;
    options.systematics.sigma0_known = false;
    const std::vector<SystematicTest> tests = tests_of(made, options);
    const SystematicTest& affinity = *of_kind(tests, SystematicKind::kAffinity);
    const SystematicTest& offset = *of_kind(tests, SystematicKind::kTimeOffset);
    sum += affinity.statistic;
    degrees += affinity.degrees;
    errors += std::pow((offset.values[0] - 0.01) / offset.sigmas[0], 2);
  }
  EXPECT_NEAR(sum, degrees, 4 * std::sqrt(2 * degrees));
  EXPECT_NEAR(errors, kBlocks, 4 * std::sqrt(2.0 * kBlocks));
}

TEST(Systematics, WhatTheBlockDoesNotDetermineIsSaidToBeSo) {
  FlightOptions flight;
  flight.control = 0;
  const std::vector<SystematicTest> tests = tests_of(flown(5, {}, flight));
  EXPECT_FALSE(of_kind(tests, SystematicKind::kShift)->determined);  // the positions place the block
  EXPECT_EQ(of_kind(tests, SystematicKind::kShift)->degrees, 0);
  EXPECT_FALSE(of_kind(tests, SystematicKind::kVerticalDatum)->determined);
  EXPECT_TRUE(of_kind(tests, SystematicKind::kTimeOffset)->determined);
  EXPECT_TRUE(of_kind(tests, SystematicKind::kShift, 1)->determined);  // tie points tell strips apart
  EXPECT_TRUE(of_kind(tests, SystematicKind::kRefraction));
}

TEST(Systematics, WithoutPositionsOnlyImagesAreTested) {
  Flown made = flown(6);
  made.scope.use_positions = false;
  const std::vector<SystematicTest> tests = tests_of(made);
  EXPECT_FALSE(of_kind(tests, SystematicKind::kTimeOffset));
  EXPECT_FALSE(of_kind(tests, SystematicKind::kShift));
  EXPECT_TRUE(of_kind(tests, SystematicKind::kAffinity)->determined);
  EXPECT_TRUE(of_kind(tests, SystematicKind::kBowl)->determined);  // by control
  for (auto& [id, control] : made.block.control) control.role = ControlRole::kCheck;
  EXPECT_FALSE(of_kind(tests_of(made), SystematicKind::kBowl));
}

TEST(Systematics, UnknownsOfTheAdjustmentAreNotTested) {
  Flown made = flown(7, {}, {.attitudes = true});
  made.scope.time_offset_sigma_s[{1}] = kNotKnown[0];
  made.scope.velocity_m_s = made.systematics.velocity_m_s;
  made.scope.lever_arms[{1}] = {Eigen::Vector3d::Zero(), kNotKnown};
  made.scope.boresight_sigma_rad[{1}] = kNotKnown;
  made.systematics.refraction_corrected = true;
  const std::vector<SystematicTest> tests = tests_of(made, looking_for_systematics(made, Calibration::kBrownAffinity));
  EXPECT_FALSE(of_kind(tests, SystematicKind::kTimeOffset));
  EXPECT_FALSE(of_kind(tests, SystematicKind::kLeverArm));
  EXPECT_FALSE(of_kind(tests, SystematicKind::kBoresight));
  EXPECT_FALSE(of_kind(tests, SystematicKind::kAffinity));
  EXPECT_FALSE(of_kind(tests, SystematicKind::kRefraction));
  EXPECT_TRUE(of_kind(tests, SystematicKind::kShift));
}

TEST(Systematics, TheTimeOffsetOfAFlightIsNamedAndTakenUp) {
  const std::vector<SystematicTest> tests = tests_of(flown(8, {.time_offset_s = 0.037}));
  const SystematicTest& offset = *of_kind(tests, SystematicKind::kTimeOffset);
  EXPECT_LT(offset.p_value, kTakenUpBelow);
  EXPECT_NEAR(offset.values[0], 0.037, 4 * offset.sigmas[0]);
  EXPECT_NEAR(offset.largest_effect, 0.037 * 8, 0.1);
  EXPECT_EQ(named_in(tests), std::vector{SystematicKind::kTimeOffset});
  const InstrumentOptions taken = taken_up(tests, {});
  EXPECT_TRUE(taken.time_offset);
  EXPECT_FALSE(taken.lever_arm);
  EXPECT_EQ(taken.position_shift, PositionShift::kNone);
  EXPECT_TRUE(named_in(tests_of(flown(8))).empty());
  EXPECT_FALSE(taken_up(tests_of(flown(8)), {}).time_offset);
}

// The shift of a strip is determined by the others, those of all are not.
TEST(Systematics, ShiftsAreTakenUpWithControlAlone) {
  const Wrong wrong{.shift_m = {0.2, 0, 0.2}, .strip = 1};
  FlightOptions flight;
  EXPECT_EQ(taken_up(tests_of(flown(14, wrong, flight)), {}).position_shift, PositionShift::kStrips);
  flight.control = 0;
  const std::vector<SystematicTest> tests = tests_of(flown(14, wrong, flight));
  EXPECT_TRUE(of_kind(tests, SystematicKind::kShift, 1)->significant);
  EXPECT_EQ(taken_up(tests, {}).position_shift, PositionShift::kNone);
}

// With one speed and the camera turned with the flight, an antenna ahead of the camera is a time offset.
TEST(Systematics, WhatCannotBeToldApartIsNamedTogether) {
  Flown made = flown(9, {.time_offset_s = 0.05});
  const std::vector<SystematicTest> tests = tests_of(made);
  const auto index = [&](SystematicKind kind) { return static_cast<std::size_t>(of_kind(tests, kind) - tests.data()); };
  const std::size_t offset = index(SystematicKind::kTimeOffset), arm = index(SystematicKind::kLeverArm);
  EXPECT_TRUE(tests[arm].significant);
  EXPECT_EQ(tests[arm].explained_by, offset);
}

TEST(Systematics, AWrongAssignmentIsNoTimeOffset) {
  const FlightOptions coarse{.position_sigma_m = 1};
  const std::vector<SystematicKind> named = named_in(tests_of(flown(10, {.assignment = 1}, coarse)));
  ASSERT_FALSE(named.empty());
  EXPECT_EQ(named[0], SystematicKind::kAssignment);
  const std::vector<SystematicTest> tests = tests_of(flown(10, {.time_offset_s = 0.5}, coarse));
  EXPECT_EQ(of_kind(tests, SystematicKind::kAssignment)->p_value, 1);  // a quarter of the way
  EXPECT_TRUE(of_kind(tests, SystematicKind::kTimeOffset)->significant);
}

TEST(Systematics, SameBitsWithAnyNumberOfThreads) {
  const Flown made = flown(11, {.time_offset_s = 0.01}, {.points = 1500});
  collinea::Run two = kRun;
  two.threads = 2;
  const ExamineOptions options = looking_for_systematics(made, Calibration::kBrown);
  const std::vector<SystematicTest> a = tests_of(made, options), b = tests_of(made, options, two);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].values, b[k].values);
    EXPECT_EQ(a[k].statistic, b[k].statistic);
    EXPECT_EQ(a[k].ground_change_m, b[k].ground_change_m);
  }
}

// Points whose images are of two cameras.
TEST(Systematics, EachCameraHasItsOwnErrors) {
  Wrong wrong{.time_offset_s = 0.01};
  Flown made = flown(12, wrong, kExact);
  made.block.cameras[{2}] = made.block.cameras.at({1});
  for (auto& [id, image] : made.block.images)
    if (id.value % 2) {
      image.camera = {2};
      image.position->position_in_world -= 0.01 * made.systematics.velocity_m_s.at(id);  // none of this one
    }
  const std::vector<SystematicTest> tests = tests_of(made);
  int found = 0;
  for (const SystematicTest& test : tests) {
    if (test.kind != SystematicKind::kTimeOffset) continue;
    ++found;
    if (test.camera == CameraId{1}) EXPECT_GT(test.values[0], 0.005);
    if (test.camera == CameraId{2}) EXPECT_LT(test.values[0], 0.005);
  }
  EXPECT_EQ(found, 2);
  EXPECT_EQ(std::ranges::count(tests, SystematicKind::kAffinity, &SystematicTest::kind), 2);
}

}  // namespace
}  // namespace collinea
