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

}  // namespace
}  // namespace collinea
