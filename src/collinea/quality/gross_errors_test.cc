// SPDX-License-Identifier: Apache-2.0
// One gross error of any size, from what is just certain to be found to a thousand kilometres.
#include "collinea/quality/gross_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "collinea/epipolar/intersect.h"
#include "collinea/quality/divergence.h"
#include "collinea/quality/internal/measurement.h"
#include "collinea/quality/internal/test_examine.h"
#include "collinea/quality/snooping.h"

namespace collinea {
namespace {

using testing::test_block;

const Run kRun;
constexpr int kMost = 1000;

ExamineOptions plain() {
  return {.adjust = {.calibration = Calibration::kNone, .loss = Loss::kNone, .position_loss = Loss::kNone}};
}

// A strip of images with that many control points.
Block strip(int images, int control, double position_sigma_m = 0, std::uint64_t seed = 1) {
  Block block = test_block({.rows = 1,
                            .columns = images,
                            .points = 60,
                            .sigma_px = 0.5,
                            .position_sigma_m = position_sigma_m,
                            .control = control,
                            .seed = seed});
  for (auto& [id, point] : block.control) point.role = ControlRole::kControl;
  return block;
}

// The best checked measurement of a group.
MeasurementIndex best_checked(const Block& block, ObservationGroup group) {
  const auto clean = examine(block, {}, testing::tested(), kRun);
  MeasurementIndex best{group};
  double redundancy = -1;
  if (clean && clean->reliability)
    for (const TestedObservation& one : clean->reliability->others)
      if (one.group == group && one.redundancy > redundancy) {
        redundancy = one.redundancy;
        best.source = one.source;
      }
  return best;
}

// Four times what is found with 80 %: where little checks it (r = 0.03) and a neighbour is correlated by 0.9 it takes
// that to tell the two apart.
double certain_size(const Block& block, MeasurementIndex index, int axis) {
  const auto clean = examine(block, {}, testing::tested(), kRun);
  if (clean && clean->reliability)
    for (const TestedObservation& one : clean->reliability->others)
      if (one.group == index.group && one.source == index.source && one.axis == axis)
        return 4 * one.minimal_detectable_bias;
  return 0;
}

double& value_at(Block& block, MeasurementIndex index, int axis) {
  switch (traits_of(index.group).source) {
    case ObservationSource::kTieImagePoint:
      return block.observations[index.source].pixel[axis];
    case ObservationSource::kControlImagePoint:
      return block.control_observations[index.source].pixel[axis];
    case ObservationSource::kControlCoordinates:
      return block.control.at(ControlId{index.source}).position_in_world[axis];
    case ObservationSource::kPosition:
      return block.images.at(ImageId{index.source}).position->position_in_world[axis];
    default:
      return block.geodetic[index.source].value;
  }
}

int tried = 0;

// It is found, named with its size, and what is left is what is left without it.
void expect_found(const Block& good, MeasurementIndex index, int axis, double size, const std::string& what) {
  SCOPED_TRACE(what + ", " + std::to_string(size));
  if (std::abs(size) < certain_size(good, index, axis)) return;
  ++tried;
  const Measurement planted = measurement_at(index, good);
  const MeasurementIndex left_out[] = {index};
  const auto expected = snoop(without({good, {}}, left_out).block, {}, plain(), kMost, kRun);
  ASSERT_TRUE(expected) << expected.error().message;
  Block block = good;
  value_at(block, index, axis) += size;
  const auto snooped = snoop(block, {}, plain(), kMost, kRun);
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_TRUE(snooped->finished);
  EXPECT_EQ(snooped->rejected.size(), expected->rejected.size() + 1);
  const auto rejected = std::find(snooped->rejected.begin(), snooped->rejected.end(), planted);
  ASSERT_NE(rejected, snooped->rejected.end());
  EXPECT_EQ(rejected->axis, axis);
  EXPECT_GT(rejected->sigma, 0);
  EXPECT_NEAR(rejected->gross_error[axis], size, 6 * rejected->sigma + 1e-9 * size);
  EXPECT_NEAR(snooped->adjusted.sigma0, expected->adjusted.sigma0, 1e-6);
  EXPECT_TRUE(snooped->adjusted.converged);
  for (const auto& [id, pose] : expected->adjusted.cam_from_world)
    EXPECT_LT((centre_of(pose) - centre_of(snooped->adjusted.cam_from_world.at(id))).norm(), 1e-5) << id.value;
}

constexpr double kSizes[] = {0.5, 3.2, 31, 150, 500, 1000, 1e4, -1e5, 1e6};

TEST(GrossErrors, OneCoordinateOfControlIsFoundHoweverWrongItIs) {
  const Block block = strip(5, 6);
  tried = 0;
  for (const int axis : {0, 1, 2}) {
    const auto index = best_checked(block, group_of(ObservationSource::kControlCoordinates, axis));
    for (const double size : kSizes) expect_found(block, index, axis, size, "control, axis " + std::to_string(axis));
  }
  EXPECT_GE(tried, 22);
}

TEST(GrossErrors, OneOfEveryControlPointIsFound) {
  const Block block = strip(4, 7, 0, 3);
  tried = 0;
  for (const auto& [id, control] : block.control)
    for (const int axis : {0, 2}) {
      if (sight_lines(block, id).size() < 2) continue;  // of one ray and its coordinates either may be wrong
      for (const double size : {40.0, 1000.0})
        expect_found(block, {group_of(ObservationSource::kControlCoordinates, axis), id.value}, axis, size,
                     control.name + ", axis " + std::to_string(axis));
    }
  EXPECT_GE(tried, 20);
}

TEST(GrossErrors, AnImagePointIsFoundHoweverWrongItIs) {
  const Block block = strip(5, 6);
  for (const auto group : {ObservationGroup::kControlImages, ObservationGroup::kTieImages})
    for (const double size : {20.0, 316.0, 1e4, -1e6}) {
      MeasurementIndex index{group, 0};
      if (group == ObservationGroup::kControlImages) index = best_checked(block, group);
      // A tie point that three images see.
      for (std::uint32_t i = 0; group == ObservationGroup::kTieImages && i + 2 < block.observations.size(); ++i)
        if (block.observations[i].point == block.observations[i + 2].point && index.source == 0) index.source = i + 1;
      expect_found(block, index, 0, size, group == ObservationGroup::kTieImages ? "tie point" : "mark of control");
    }
}

// Positions alone, and three control points that positions check.
TEST(GrossErrors, APositionIsFoundHoweverWrongItIs) {
  for (const int control : {0, 3}) {
    const Block block = test_block({.rows = 2,
                                    .columns = 4,
                                    .points = 60,
                                    .sigma_px = 0.5,
                                    .position_sigma_m = 0.05,
                                    .control = control,
                                    .seed = 2});
    for (const int axis : {0, 2})
      for (const double size : {3.2, 100.0, 1000.0, 1e6})
        expect_found(block, {group_of(ObservationSource::kPosition, axis), 12}, axis, size,
                     std::to_string(control) + " control points, axis " + std::to_string(axis));
  }
}

TEST(GrossErrors, ThreeControlPointsAreEnoughBesidePositions) {
  Block block = test_block(
      {.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 3, .seed = 4});
  for (auto& [id, point] : block.control) point.role = ControlRole::kControl;
  for (const int axis : {0, 1, 2})
    for (const double size : {3.2, 100.0, 1e3, 1e6})
      expect_found(block, {group_of(ObservationSource::kControlCoordinates, axis), 1}, axis, size,
                   "axis " + std::to_string(axis));
}

TEST(GrossErrors, ADistanceIsFoundHoweverWrongItIs) {
  Block block = strip(5, 6);
  for (std::uint32_t i = 1; i < 6; ++i) {
    const double value = (block.control.at({i}).position_in_world - block.control.at({i - 1}).position_in_world).norm();
    block.geodetic.push_back({.from = {i - 1}, .to = {i}, .value = value, .sigma = 0.02});
  }
  for (const double size : {1.0, 31.0, 1000.0, 1e6})
    expect_found(block, {ObservationGroup::kDistance, 2}, 0, size, "distance");
}

// Of four points one wrong in plan leaves three, which two differences of distances check. Of three one is left that
// nothing checks: that they contradict each other shows, which is wrong does not, and it is said so.
TEST(GrossErrors, FourControlPointsAreEnoughAndThreeAreNot) {
  const Block four = strip(5, 4);
  const auto index = best_checked(four, ObservationGroup::kControlPlan);
  for (const double size : {3.2, 100.0, 1000.0, 1e6}) expect_found(four, index, 0, size, "four points");

  const Block three = strip(5, 3);
  for (const double size : {3.2, 100.0, 1000.0, 1e6}) {
    SCOPED_TRACE(size);
    Block block = three;
    block.control.at({1}).position_in_world.x() += size;
    const auto snooped = snoop(block, {}, plain(), kMost, kRun);
    if (!snooped) {
      EXPECT_TRUE(snooped.error().code == Errc::kNotConverged || snooped.error().code == Errc::kIllPosed);
      EXPECT_NE(snooped.error().message.find("gcp1 (control_plan"), std::string::npos) << snooped.error().message;
      continue;
    }
    EXPECT_TRUE(snooped->rejected.empty());
    EXPECT_FALSE(snooped->kept.empty());
    EXPECT_GT(snooped->adjusted.sigma0, 1.5);
  }
}

TEST(GrossErrors, FindsWhatBendsAnAdjustmentByName) {
  Block block = strip(5, 6);
  block.control.at({3}).position_in_world.y() += 1000;
  const auto adjusted = examine(block, {}, testing::tested(), kRun);
  EXPECT_TRUE(is_bent(adjusted, {}));
  const GrossErrors found = find_gross_errors(block, {}, plain().adjust, nullptr, kRun);
  ASSERT_EQ(found.measurements.size(), 1u);
  EXPECT_EQ(found.measurements[0].group, ObservationGroup::kControlPlan);
  EXPECT_EQ(found.measurements[0].control, ControlId{3});
  EXPECT_EQ(found.measurements[0].axis, 1);
  EXPECT_NEAR(found.measurements[0].gross_error.y(), 1000, 0.5);
}

// Before, it ended with what it had come to: sigma0 0, redundancy -160, and no error.
TEST(GrossErrors, WhatHasDivergedIsRefusedByName) {
  for (const double size : {100.0, 1000.0, 1e6}) {
    SCOPED_TRACE(size);
    Block block = strip(5, 6);
    block.control.at({3}).position_in_world.y() += size;
    const auto adjusted = examine_strictly(block, {}, testing::tested(), kRun);
    if (adjusted) {  // bent, but an adjustment
      EXPECT_TRUE(adjusted->converged && adjusted->reliability && adjusted->reliability->unseen == 0);
      EXPECT_GT(adjusted->sigma0, 20);
      continue;
    }
    EXPECT_TRUE(adjusted.error().code == Errc::kNotConverged || adjusted.error().code == Errc::kIllPosed);
    EXPECT_NE(adjusted.error().message.find("misfits: gcp3 (control_plan +" + std::to_string(int(size) / 10)),
              std::string::npos)
        << adjusted.error().message;
  }
  const auto good = examine_strictly(strip(5, 6), {}, testing::tested(), kRun);
  EXPECT_TRUE(good);
}

// A fixed point has no observation that could be tested; its marks would all be suspect.
TEST(GrossErrors, AFixedCoordinateGoes) {
  for (const double size : {10.0, 1000.0}) {
    SCOPED_TRACE(size);
    Block block = strip(5, 6);
    for (auto& [id, point] : block.control) point.sigma_m.setZero();
    block.control.at({3}).position_in_world.x() += size;
    const auto snooped = snoop(block, {}, plain(), kMost, kRun);
    ASSERT_TRUE(snooped) << snooped.error().message;
    ASSERT_FALSE(snooped->rejected.empty());
    EXPECT_EQ(snooped->rejected[0].group, ObservationGroup::kControlPlan);
    EXPECT_EQ(snooped->rejected[0].control, ControlId{3});
    EXPECT_NEAR(snooped->rejected[0].gross_error.x(), size, 0.2);
    EXPECT_LT(snooped->adjusted.sigma0, 1.5);
  }
}

TEST(GrossErrors, AGoodBlockIsNotBentAndHasNone) {
  const Block block = strip(5, 6);
  const auto adjusted = examine(block, {}, testing::tested(), kRun);
  ASSERT_TRUE(adjusted);
  EXPECT_FALSE(is_bent(adjusted, {}));
  const GrossErrors found = find_gross_errors(block, {}, plain().adjust, &*adjusted, kRun);
  EXPECT_TRUE(found.measurements.empty());
  EXPECT_EQ(found.lost_rays, 0);
  EXPECT_EQ(found.rays, long(block.observations.size() + block.control_observations.size()));
}

}  // namespace
}  // namespace collinea
