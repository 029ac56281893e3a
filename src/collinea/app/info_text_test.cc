// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/info_text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace collinea {
namespace {

using nlohmann::json;

ProjectInfo set_up() {
  ProjectInfo info;
  info.setup.images[{0}].file = "a.jpg";
  info.setup.images[{1}].file = "b.jpg";
  info.setup.cameras[{0}] = {};
  info.setup.control[{2}].name = "P3";
  info.setup.control[{5}].name = "K6";
  return info;
}

ProjectInfo oriented() {
  ProjectInfo info = set_up();
  info.setup.georeference = Georeference{"EPSG:32633", 45, 15, 100};
  OrientationRecord record{.images = 2,
                           .oriented = 1,
                           .tie_points = 30,
                           .observations = 75,
                           .mean_reprojection_px = 0.5,
                           .pixel_size = 0.0204,
                           .metric = true,
                           .gauge = {.map = "EPSG:32633", .by_control = true},
                           .findings = {finding_of(FindingCode::kLocalGauge)}};
  record.not_oriented = {{1}};
  AdjustmentRecord adjusted{.tie_points = 29, .observations = 73, .mean_reprojection_px = 0.45678, .sigma0 = 1.01};
  adjusted.control_rmse_m = {0.01, 0.0204, std::nullopt};
  ControlDifference& used = adjusted.control.emplace_back();
  used.point = {2};
  used.used = true;
  used.rays = 4;
  used.difference_m = {0.02, -0.07, std::nan("")};
  used.difference_sigma_m = {0.02, 0.02, std::nan("")};
  ControlDifference& wrong = adjusted.control.emplace_back();
  wrong.point = {5};
  wrong.excluded = true;
  adjusted.control.emplace_back().point = {77};  // set up no more
  info.steps = {{"a", "b", 1.5, 2.5, 3e6, DetectRecord{.images = 2, .features = 9}},
                {"b", "c", 4, 5, 6e6, record},
                {"c", "d", 1, 2, 3e6, adjusted}};
  return info;
}

TEST(InfoText, BeforeOrientationFiguresAreNullOrZero) {
  const json info = json::parse(info_json(set_up()));
  EXPECT_EQ(info.at("images"), 2);
  EXPECT_EQ(info.at("cameras"), 1);
  EXPECT_EQ(info.at("oriented"), 0);
  for (const char* key : {"mean_reprojection_px", "gsd_m", "control_rmse_m", "check_rmse_m"})
    EXPECT_TRUE(info.at(key).is_null()) << key;
  EXPECT_TRUE(info.at("control_points").empty());
  EXPECT_TRUE(info.at("steps").empty());
  EXPECT_FALSE(info.contains("crs"));
  const std::string text = info_text(set_up());
  EXPECT_NE(text.find("images                 2 (0 oriented)"), std::string::npos) << text;
  EXPECT_NE(text.find("mean reprojection      not known yet"), std::string::npos) << text;
  EXPECT_NE(text.find("ground sample          not known yet"), std::string::npos) << text;
  EXPECT_NE(text.find("map                    none: local gauge"), std::string::npos) << text;
}

TEST(InfoText, TheOrientationIsStatedUnderItsKeys) {
  const json info = json::parse(info_json(oriented()));
  EXPECT_EQ(info.at("crs"), "EPSG:32633");
  EXPECT_EQ(info.at("oriented"), 1);
  EXPECT_EQ(info.at("tie_points"), 29);
  EXPECT_EQ(info.at("gsd_m"), 0.0204);
  EXPECT_EQ(info.at("control_rmse_m").dump(), "[0.01,0.0204,null]");
  EXPECT_TRUE(info.at("check_rmse_m").is_null());
  EXPECT_EQ(info.at("gauge"), "in EPSG:32633, fixed by control points");
  EXPECT_EQ(info.at("not_oriented").dump(), R"(["b.jpg"])");
  ASSERT_EQ(info.at("findings").size(), 1u);
  EXPECT_EQ(info.at("findings").at(0).at("code"), "local_gauge");
  EXPECT_EQ(info.at("findings").at(0).at("severity"), "note");
  EXPECT_EQ(info.at("calibration"), "none");
  ASSERT_EQ(info.at("steps").size(), 3u);
  EXPECT_EQ(info.at("steps").at(0).at("name"), "detect");
  EXPECT_EQ(info.at("steps").at(0).at("cpu_seconds"), 2.5);
  EXPECT_EQ(info.at("steps").at(0).at("figures").at("features"), 9);
}

TEST(InfoText, ControlPointsAreNamedWithTheirRoles) {
  const json points = json::parse(info_json(oriented())).at("control_points");
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points.at(0).at("name"), "P3");
  EXPECT_EQ(points.at(0).at("role"), "control");
  EXPECT_EQ(points.at(0).at("images"), 4);
  EXPECT_EQ(points.at(0).at("difference_m").dump(), "[0.02,-0.07,null]");
  EXPECT_EQ(points.at(0).at("sigma_m").dump(), "[0.02,0.02,null]");
  EXPECT_TRUE(points.at(0).at("beyond_3_sigma").get<bool>());
  EXPECT_EQ(points.at(1).at("role"), "excluded");
  EXPECT_FALSE(points.at(1).at("beyond_3_sigma").get<bool>());
}

TEST(InfoText, PeopleReadTheSameFigures) {
  const std::string text = info_text(oriented());
  for (const char* line :
       {"images                 2 (1 oriented)", "map                    EPSG:32633",
        "tie points             29 with 73 observations", "mean reprojection      0.4568 px",
        "ground sample          0.0204 m", "control RMSE           0.010 / 0.020 / - m (east / north / height)",
        "check RMSE             none", "step detect                 1.5 s      2.5 CPU-s      3 MB",
        "note                   Positions and control do not fix where the block lies (fewer than three, or all "
        "on one "
        "line): local gauge."})
    EXPECT_NE(text.find(std::string(line) + "\n"), std::string::npos) << line << "\n" << text;
}

}  // namespace
}  // namespace collinea
