// SPDX-License-Identifier: Apache-2.0
// Gross errors that mask each other, or make a good measurement look wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "collinea/epipolar/intersect.h"
#include "collinea/quality/internal/measurement.h"
#include "collinea/quality/internal/test_examine.h"
#include "collinea/quality/snooping.h"

namespace collinea {
namespace {

using testing::test_block;

// A strip of five images.
Block strip(int control, std::uint64_t seed) {
  Block block = test_block({.rows = 1, .columns = 5, .points = 60, .sigma_px = 0.5, .control = control, .seed = seed});
  for (auto& [id, point] : block.control) point.role = ControlRole::kControl;
  return block;
}

ExamineOptions plain() {
  return {.adjust = {.calibration = Calibration::kNone, .loss = Loss::kNone, .position_loss = Loss::kNone}};
}

// What was given that went: coordinates by their point, marks too.
std::set<std::pair<ObservationGroup, ControlId>> rejected_names(const Snooped& snooped) {
  std::set<std::pair<ObservationGroup, ControlId>> names;
  for (const Rejected& one : snooped.rejected)
    if (one.group != ObservationGroup::kTieImages) names.emplace(one.group, one.control);
  return names;
}

// One wrong height of four or six, by a slip of the decimal point and by a metre. One after the other it took plans and
// marks of good points with it, or marks of its own point in its place, in four of these.
TEST(MaskedErrors, OneWrongHeightTakesNothingElseWithIt) {
  int clean = 0, all = 0;
  for (const int control : {4, 6})
    for (std::uint64_t seed = 1; seed <= 3; ++seed)
      for (std::uint32_t point = 0; point < 2; ++point)
        for (const bool slip : {true, false}) {
          SCOPED_TRACE(std::to_string(control) + " points, seed " + std::to_string(seed) + ", point " +
                       std::to_string(point) + (slip ? ", slip" : ""));
          Block block = strip(control, seed);
          double& height = block.control.at({point}).position_in_world.z();
          height = slip ? height / 10 : height + 1;
          const auto snooped = snoop(block, {}, plain(), 1000, {});
          ASSERT_TRUE(snooped) << snooped.error().message;
          ++all;
          const auto is_height = std::pair(ObservationGroup::kControlHeight, ControlId{point});
          const auto is_mark = std::pair(ObservationGroup::kControlImages, ControlId{point});
          clean += rejected_names(*snooped) == std::set{is_height};
          // Or the marks of the point, which say the same of it.
          EXPECT_TRUE(rejected_names(*snooped) == std::set{is_height} || rejected_names(*snooped) == std::set{is_mark});
        }
  EXPECT_GE(clean, all - 1);
}

// Every pair of eight heights wrong by 0.3 m to the same side, about 30 given sigmas: one after the other finds 4 of
// 56, since two tilt the strip and a good one looks worst.
TEST(MaskedErrors, PairsOfHeightsThatTiltTheStripAreFound) {
  int found = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 2; ++seed)
    for (std::uint32_t a = 0; a < 8; ++a)
      for (std::uint32_t b = a + 1; b < 8; ++b) {
        Block block = strip(8, seed);
        for (const std::uint32_t point : {a, b}) block.control.at({point}).position_in_world.z() += 0.3;
        const auto snooped = snoop(block, {}, plain(), 1000, {});
        ASSERT_TRUE(snooped) << snooped.error().message;
        ++all;
        found += rejected_names(*snooped) == std::set{std::pair(ObservationGroup::kControlHeight, ControlId{a}),
                                                      std::pair(ObservationGroup::kControlHeight, ControlId{b})};
      }
  EXPECT_EQ(all, 56);
  EXPECT_GE(found, 44);
}

TEST(MaskedErrors, TriplesOfPlansAreFound) {
  int found = 0, all = 0;
  for (std::uint32_t a = 0; a < 6; ++a) {
    Block block = strip(9, 1);
    std::set<std::pair<ObservationGroup, ControlId>> wrong;
    for (const std::uint32_t point : {a, a + 1, a + 3}) {
      block.control.at({point}).position_in_world.x() += 0.5;
      wrong.emplace(ObservationGroup::kControlPlan, ControlId{point});
    }
    const auto snooped = snoop(block, {}, plain(), 1000, {});
    ASSERT_TRUE(snooped) << snooped.error().message;
    ++all;
    found += rejected_names(*snooped) == wrong;
  }
  EXPECT_GE(found, all - 1);
}

// The plan of a point that one image shows, and its mark there, say the same: whichever goes, both are named.
TEST(MaskedErrors, WhatSaysTheSameIsNamed) {
  int named = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Block good = strip(6, seed);
    for (const auto& [id, point] : good.control) {
      if (sight_lines(good, id).size() != 1) continue;
      Block block = good;
      block.control.at(id).position_in_world.x() += 0.5;
      const auto snooped = snoop(block, {}, plain(), 1000, {});
      ASSERT_TRUE(snooped) << snooped.error().message;
      ++all;
      named += std::ranges::any_of(snooped->inseparable, [&](const InseparableSets& sets) {
        std::set<ObservationGroup> groups;
        for (const auto* part : {&sets.either, &sets.or_else})
          for (const Measurement& one : *part)
            if (one.control == id) groups.insert(one.group);
        return groups.contains(ObservationGroup::kControlPlan) && groups.contains(ObservationGroup::kControlImages);
      });
    }
  }
  EXPECT_GT(all, 0);
  EXPECT_EQ(named, all);
}

TEST(MaskedErrors, AGoodBlockLosesNothing) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto snooped = snoop(strip(8, seed), {}, plain(), 1000, {});
    ASSERT_TRUE(snooped);
    EXPECT_TRUE(rejected_names(*snooped).empty());
    EXPECT_TRUE(snooped->inseparable.empty());
  }
}

}  // namespace
}  // namespace collinea
