// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/gross_geodetic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "collinea/adjust/geodetic_model.h"
#include "collinea/adjust/test_block.h"

namespace collinea {
namespace {

constexpr double kZero_rad = 2;  // of the horizontal circle

// An exact block with each kind of measurement from the first control point to four others.
Block measured_block() {
  Block block = testing::test_block({.rows = 2, .columns = 3, .points = 20, .control = 8});
  for (const GeodeticKind kind :
       {GeodeticKind::kDistance, GeodeticKind::kHeightDifference, GeodeticKind::kDirection, GeodeticKind::kZenithAngle})
    for (std::uint32_t to = 1; to <= 4; ++to) {
      GeodeticObservation one{.kind = kind, .from = {0}, .to = {to}, .sigma = 1e-4, .setup = 0};
      one.value = geodetic_model(one, block.control.at({0}).position_in_world, block.control.at({to}).position_in_world,
                                 kZero_rad, {true})
                      .computed;
      block.geodetic.push_back(one);
    }
  return block;
}

TEST(GrossGeodetic, GoodMeasurementsStay) {
  const GrossGeodetic found = gross_geodetic(measured_block(), 0.005);
  EXPECT_TRUE(found.excluded.empty());
  EXPECT_TRUE(found.findings.empty());
}

TEST(GrossGeodetic, ASlipInAnyKindIsRejectedAlone) {
  for (std::size_t i = 0; i < 16; ++i) {
    Block block = measured_block();
    GeodeticObservation& wrong = block.geodetic[i];
    wrong.value += wrong.is_angle() ? 0.2 : 30;
    const GrossGeodetic found = gross_geodetic(block, 0.1);
    ASSERT_EQ(found.excluded, std::vector<std::size_t>{i});
    EXPECT_EQ(found.findings[0].code, FindingCode::kGrossErrorRejected);
    EXPECT_EQ(found.findings[0].subjects[0], Subject::geodetic(i));
    EXPECT_NEAR(found.findings[0].figure(wrong.is_angle() ? FigureName::kDifferenceAngle : FigureName::kOffset).value(),
                wrong.is_angle() ? 0.2 * 180 / std::numbers::pi : 30, 1e-6);
  }
}

TEST(GrossGeodetic, WhatIsOnlyComparedOrHardlyOffStays) {
  Block block = measured_block();
  block.geodetic[0].value *= 10;
  block.geodetic[0].role = ControlRole::kCheck;
  block.geodetic[1].value *= 1.05;
  block.geodetic[2].sigma = 100;
  block.geodetic[2].value += 50;
  EXPECT_TRUE(gross_geodetic(block, 0.1).excluded.empty());
  EXPECT_EQ(gross_geodetic(block, 0.005).excluded, std::vector<std::size_t>{1});
}

TEST(GrossGeodetic, APointThatOneImageSeesSaysNothing) {
  Block block = measured_block();
  std::erase_if(block.control_observations, [](const ControlObservation& seen) { return seen.point == ControlId{0}; });
  for (GeodeticObservation& one : block.geodetic) one.value *= 2;
  EXPECT_TRUE(gross_geodetic(block, 0.005).excluded.empty());
}

TEST(GrossGeodetic, VagueOrNarrowControlKnowsLess) {
  Block block = measured_block();
  const std::set<ControlId> three{{0}, {1}, {2}};
  for (auto& [id, point] : block.control) point.sigma_m.setConstant(1e-4);
  EXPECT_EQ(known_part(block, three, 1), 0.005);
  EXPECT_EQ(known_part(block, {{0}, {1}}, 0.001), 0.1);
  EXPECT_EQ(known_part(block, {{0}, {1}}, 0.1), 0.5);  // positions that hardly tell the scale
  for (auto& [id, point] : block.control) point.sigma_m.setConstant(100);
  EXPECT_GT(known_part(block, three, 0), 1);
}

}  // namespace
}  // namespace collinea
