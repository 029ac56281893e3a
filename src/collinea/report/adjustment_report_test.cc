// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/adjustment_report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "collinea/image/test_folder.h"
#include "collinea/io/file.h"
#include "collinea/report/adjustment_products.h"

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
  EXPECT_NE(adjustment_page(report, {}).find("Systematic residuals"), std::string::npos);
}

TEST(WriteAdjustment, WhatIsWeakIsToldWithItsCure) {
  AdjustmentReport report;
  report.adjusted.weaknesses.push_back({"no_datum", "nothing fixes the scale", "a known distance", 1});
  const auto weak = nlohmann::json::parse(adjustment_json(report)).at("weaknesses");
  EXPECT_EQ(weak.at(0).at("cure"), "a known distance");
  EXPECT_NE(adjustment_page(report, {}).find("Cure: a known distance"), std::string::npos);
}

// Errors of 3 and 4 cm in plan and of 5 and 1 cm in height; survey 1 cm on each axis; control and points that are
// surveyed in height only do not count in plan.
TEST(WriteAdjustment, AccuracyAtCheckPointsHoldsThatOfTheirSurvey) {
  AdjustmentReport report;
  const auto add = [&](std::uint32_t id, bool used, const Eigen::Vector3d& difference_m, double plan_sigma_m) {
    report.block.control[{id}].name = "P" + std::to_string(id);
    report.block.control[{id}].sigma_m = {plan_sigma_m, plan_sigma_m, 0.01};
    report.block.control[{id}].role = used ? ControlRole::kControl : ControlRole::kCheck;
    ControlDifference& one = report.adjusted.control.emplace_back();
    one.point = {id};
    one.used = used;
    one.difference_m = difference_m;
  };
  constexpr double kInfinity = std::numeric_limits<double>::infinity(), kNaN = std::numeric_limits<double>::quiet_NaN();
  add(1, false, {0.03, 0, 0.05}, 0.01);
  add(2, false, {0, 0.04, -0.01}, 0.01);
  add(3, true, {1, 1, 1}, 0.01);
  add(4, false, {kNaN, kNaN, 0.01}, kInfinity);
  add(5, false, {9, 9, 9}, 0.01);  // control that was found wrong and taken out
  report.block.control[{5}].role = ControlRole::kControl;
  const auto accuracy = nlohmann::json::parse(adjustment_json(report)).at("accuracy");
  const auto& plan = accuracy.at("horizontal");
  const auto& height = accuracy.at("vertical");
  EXPECT_EQ(plan.at("check_points"), 2);
  EXPECT_NEAR(plan.at("fit_rmse_m").get<double>(), std::sqrt((9e-4 + 16e-4) / 2), 1e-12);
  EXPECT_NEAR(plan.at("survey_rmse_m").get<double>(), std::sqrt(2e-4), 1e-12);
  EXPECT_NEAR(plan.at("rmse_m").get<double>(), std::sqrt(12.5e-4 + 2e-4), 1e-12);
  EXPECT_EQ(height.at("check_points"), 3);
  EXPECT_NEAR(height.at("rmse_m").get<double>(), std::sqrt(27e-4 / 3 + 1e-4), 1e-12);
  EXPECT_NEAR(accuracy.at("rmse_3d_m").get<double>(), std::sqrt(14.5e-4 + 10e-4), 1e-12);
  EXPECT_FALSE(accuracy.at("enough_check_points").get<bool>());
  // Adjusted without any control, all points are check points.
  report.adjusted.control[2].used = false;
  const auto without = nlohmann::json::parse(adjustment_json(report)).at("accuracy");
  EXPECT_EQ(without.at("horizontal").at("check_points"), 4);
}

}  // namespace
}  // namespace collinea
