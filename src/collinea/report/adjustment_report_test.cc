// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/adjustment_report.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "collinea/image/test_folder.h"
#include "collinea/io/file.h"

namespace collinea {
namespace {

TEST(WriteAdjustment, ACalibratedCameraWithoutCovarianceHasNoSigmasAndAHeldOneHasZeros) {
  const TestFolder folder;
  AdjustmentReport report;
  report.block.georeference = Georeference{"EPSG:32633", 45, 15, 100};
  report.block.cameras[{1}] = report.block.cameras[{2}] = ideal_camera(1500, 2000, 1500);
  report.block.cameras[{1}].name = "free";
  report.block.cameras[{2}].name = "held";
  report.adjusted.cameras[{1}] = report.block.cameras[{1}];
  report.adjusted.undetermined = "the scale";
  ASSERT_TRUE(write_adjustment(report, folder / "out"));
  const std::string table = *read_file(folder / "out" / "cameras.csv");
  EXPECT_NE(table.find("\"free\",f,px,1500,\n"), std::string::npos) << table;
  EXPECT_NE(table.find("\"held\",f,px,1500,0\n"), std::string::npos) << table;
}

TEST(WriteAdjustment, AFactorThatNothingSupportsIsNull) {
  AdjustmentReport report;
  report.adjusted.reliability.emplace();
  GroupSums& tie = report.adjusted.reliability->groups[static_cast<std::size_t>(ObservationGroup::kTieImages)];
  tie = {.observations = 100, .redundancy = 50, .squared_redundancy = 25, .squares = 200};
  GroupSums& control = report.adjusted.reliability->groups[static_cast<std::size_t>(ObservationGroup::kControlPlan)];
  control = {.observations = 4, .redundancy = 3.5, .squared_redundancy = 2.9, .squares = 2};
  const auto groups = nlohmann::json::parse(adjustment_json(report)).at("reliability").at("groups");
  ASSERT_EQ(groups.size(), 2u);
  EXPECT_NEAR(groups.at(0).at("sigma_factor").get<double>(), 2, 1e-12);
  EXPECT_TRUE(groups.at(1).at("sigma_factor").is_null());
}

// Two cells of a grid of 12 x 9: one pulls to the right, the other only scatters.
TEST(WriteAdjustment, ASystematicResidualIsSignificantAndScatterIsNot) {
  AdjustmentReport report;
  report.block.cameras[{1}] = ideal_camera(1000, 1200, 900);
  report.block.images[{1}] = {"a.jpg", CameraId{1}, "", {}, {}, 1};
  for (std::uint32_t i = 0; i < 100; ++i) {
    const double sign = i % 2 ? 1 : -1;
    report.block.observations.push_back({ImageId{1}, PointId{i}, 0, {i < 50 ? 50.0 : 750.0, 450}, 1});
    report.adjusted.observations.push_back(i);
    report.adjusted.residuals_px.emplace_back((i < 50 ? 0.3 : 0) + 0.4 * sign, 0.4 * (i % 4 < 2 ? 1 : -1));
  }
  const auto camera = nlohmann::json::parse(adjustment_json(report)).at("residuals").at("cameras").at(0);
  ASSERT_EQ(camera.at("cells").size(), 2u);
  EXPECT_EQ(camera.at("cells_significant"), 1);
  EXPECT_EQ(camera.at("cells").at(0).at("column"), 0);
  EXPECT_EQ(camera.at("cells").at(0).at("row"), 4);
  EXPECT_NEAR(camera.at("cells").at(0).at("mean_px").at(0).get<double>(), 0.3, 1e-12);
  EXPECT_GT(camera.at("cells").at(0).at("chi_squared").get<double>(), 20);
  EXPECT_NE(adjustment_page(report).find("Systematic residuals"), std::string::npos);
}

TEST(WriteAdjustment, WhatIsWeakIsToldWithItsCure) {
  AdjustmentReport report;
  report.adjusted.weaknesses.push_back({"no_datum", "nothing fixes the scale", "a known distance", 1});
  const auto weak = nlohmann::json::parse(adjustment_json(report)).at("weaknesses");
  EXPECT_EQ(weak.at(0).at("cure"), "a known distance");
  EXPECT_NE(adjustment_page(report).find("Cure: a known distance"), std::string::npos);
}

}  // namespace
}  // namespace collinea
