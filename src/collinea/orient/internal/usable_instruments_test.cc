// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/usable_instruments.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

// A surveyed point that two images see.
Block with_control() {
  Block block;
  block.control[ControlId{1}].role = ControlRole::kControl;
  block.control[ControlId{1}].sigma_m = {0.01, 0.01, 0.01};
  for (const std::uint32_t image : {1, 2})
    block.control_observations.push_back({.point = ControlId{1}, .image = ImageId{image}});
  return block;
}

InstrumentOptions everything() {
  InstrumentOptions options;
  options.position_shift = PositionShift::kBlock;
  options.position_drift = options.time_offset = options.use_attitudes = true;
  return options;
}

std::vector<FindingCode> codes_of(const UsableInstruments& usable) {
  std::vector<FindingCode> codes;
  for (const Finding& finding : usable.findings) codes.push_back(finding.code);
  return codes;
}

TEST(UsableInstruments, InTheWorldWithControlAllTakePart) {
  const UsableInstruments usable = usable_instruments(everything(), with_control(), {}, true);
  EXPECT_TRUE(usable.findings.empty());
  EXPECT_EQ(usable.options.position_shift, PositionShift::kBlock);
  EXPECT_TRUE(usable.options.position_drift && usable.options.time_offset && usable.options.use_attitudes);
}

TEST(UsableInstruments, WithoutTheWorldNoneTakesPartAndEachIsNamed) {
  const UsableInstruments usable = usable_instruments(everything(), with_control(), {}, false);
  EXPECT_EQ(codes_of(usable), (std::vector{FindingCode::kPositionsUnused, FindingCode::kAttitudesUnused}));
  EXPECT_EQ(usable.options.position_shift, PositionShift::kNone);
  EXPECT_FALSE(usable.options.position_drift || usable.options.time_offset || usable.options.use_attitudes);
  EXPECT_TRUE(usable_instruments({}, with_control(), {}, false).findings.empty());
}

TEST(UsableInstruments, AShiftNeedsASurveyedPointThatTwoImagesSee) {
  Block check = with_control(), seen_once = with_control();
  check.control[ControlId{1}].role = ControlRole::kCheck;
  seen_once.control_observations.pop_back();
  for (const Block& block : {check, seen_once, Block{}}) {
    const UsableInstruments usable = usable_instruments(everything(), block, {}, true);
    EXPECT_EQ(codes_of(usable), std::vector{FindingCode::kShiftUnused});
    EXPECT_EQ(usable.options.position_shift, PositionShift::kNone);
    EXPECT_FALSE(usable.options.position_drift);
    EXPECT_TRUE(usable.options.time_offset && usable.options.use_attitudes);
  }
}

}  // namespace
}  // namespace collinea
