// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/adjustment_report.h"
#include "collinea/report/write_adjustment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/report/internal/adjustment_findings.h"
#include "collinea/report/internal/adjustment_products.h"

namespace collinea {
namespace {

TEST(WriteAdjustment, ACalibratedCameraWithoutCovarianceHasNoSigmasAndAFixedOneHasZeros) {
  const TestFolder folder;
  AdjustmentReport report;
  report.block.georeference = Georeference{"EPSG:32633", 45, 15, 100};
  report.block.cameras[{1}] = report.block.cameras[{2}] = ideal_camera(1500, 2000, 1500);
  report.block.cameras[{1}].name = "free";
  report.block.cameras[{2}].name = "held";
  report.adjusted.cameras[{1}] = report.block.cameras[{1}];
  report.adjusted.undetermined = finding_of(FindingCode::kUndetermined, {Subject(Aspect::kScale)});
  ASSERT_TRUE(write_adjustment(report, folder / "out", {}));
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

TEST(WriteAdjustment, TestsOfResidualsAreListedWithThoseThatAreSignificantFirst) {
  AdjustmentReport report;
  report.block.cameras[{1}].name = "wide";
  report.residual_level = 0.001;
  report.residual_tests.push_back({.kind = ResidualTestKind::kRuns,
                                   .series = ResidualSeries::kInImages,
                                   .axis = 1,
                                   .camera = CameraId{1},
                                   .count = 100,
                                   .value = 49,
                                   .expected = 50,
                                   .rms = 0.3,
                                   .p_value = 0.4});
  report.residual_tests.push_back({.kind = ResidualTestKind::kAutocorrelation,
                                   .series = ResidualSeries::kPositions,
                                   .axis = 2,
                                   .strip = 1,
                                   .count = 40,
                                   .value = 0.6,
                                   .correlation = 0.6,
                                   .rms = 0.03,
                                   .p_value = 1e-5,
                                   .p_corrected = 2e-5,
                                   .significant = true});
  const auto json = nlohmann::json::parse(adjustment_json(report)).at("residual_tests");
  EXPECT_EQ(json.at("level"), 0.001);
  EXPECT_EQ(json.at("tests").at(0).at("camera"), "wide");
  EXPECT_EQ(json.at("tests").at(0).at("series"), "in_images");
  EXPECT_EQ(json.at("tests").at(0).at("rms_px"), 0.3);
  EXPECT_EQ(json.at("tests").at(1).at("test"), "autocorrelation");
  EXPECT_EQ(json.at("tests").at(1).at("axis"), "up");
  EXPECT_EQ(json.at("tests").at(1).at("strip"), 2);
  const std::string page = adjustment_page(report, {});
  EXPECT_NE(page.find("1 of 2 is"), std::string::npos);
  EXPECT_LT(page.find("positions, up, strip 2"), page.find("neighbours in images, rows, wide"));
}

TEST(WriteAdjustment, SetsThatCannotBeToldApartAreNamed) {
  AdjustmentReport report;
  report.snooped.emplace();
  for (std::uint32_t i = 0; i < 4; ++i) report.snooped->block.control[{i}].name = "P" + std::to_string(i);
  const auto height = [](std::uint32_t i) {
    return Measurement{.group = ObservationGroup::kControlHeight, .control = ControlId{i}};
  };
  report.snooped->inseparable.push_back({{height(0), height(1)}, {height(2), height(3)}});
  EXPECT_NE(adjustment_page(report, {}).find("P0, height and P1, height, or P2, height and P3, height"),
            std::string::npos);
  const auto sets = nlohmann::json::parse(snooping_json(report).dump()).at("inseparable");
  EXPECT_EQ(sets,
            nlohmann::json::parse(R"([{"either": ["P0, height", "P1, height"], "or": ["P2, height", "P3, height"]}])"));
}

TEST(WriteAdjustment, WhatIsWeakIsStatedWithItsRemedy) {
  AdjustmentReport report;
  report.adjusted.weaknesses.push_back(finding_of(FindingCode::kDatumDefect, {Subject(Aspect::kScale)},
                                                  {{FigureName::kDefect, 1}}, {RemedyCode::kGiveScale}));
  const auto weak = nlohmann::json::parse(adjustment_json(report)).at("weaknesses");
  EXPECT_EQ(weak.at(0).at("code"), "datum_defect");
  EXPECT_EQ(weak.at(0).at("severity"), "weak");
  EXPECT_EQ(weak.at(0).at("what"), "Nothing fixes the scale.");
  EXPECT_NE(weak.at(0).at("remedy").get<std::string>().find("known distance"), std::string::npos);
  EXPECT_NE(adjustment_page(report, {}).find("Remedy: Give a known distance"), std::string::npos);
}

TEST(WriteAdjustment, SystematicErrorsAreNamedWithEveryTest) {
  AdjustmentReport report;
  report.block.cameras[{1}].name = "FC6310";
  EXPECT_FALSE(nlohmann::json::parse(adjustment_json(report)).contains("systematics"));
  SystematicTest offset{.kind = SystematicKind::kTimeOffset, .camera = CameraId{1}};
  offset.values = {0.037};
  offset.sigmas = {0.003};
  offset.unit = "s";
  offset.effect_unit = "m";
  offset.p_value = 1e-9;
  offset.p_corrected = 2e-8;
  offset.significant = offset.determined = true;
  SystematicTest arm{.kind = SystematicKind::kLeverArm, .camera = CameraId{1}};
  arm.values = {0, 0.3, 0};
  arm.sigmas = {0.01, 0.02, std::numeric_limits<double>::infinity()};
  arm.unit = arm.effect_unit = "m";
  arm.significant = true;
  arm.explained_by = 0;
  report.adjusted.systematics = {offset, arm};
  const auto j = nlohmann::json::parse(adjustment_json(report)).at("systematics");
  EXPECT_TRUE(j.at("taken_up").empty());
  EXPECT_EQ(j.at("named").size(), 1);
  EXPECT_EQ(j.at("named").at(0).at("code"), "systematic");
  EXPECT_EQ(j.at("tests").size(), 2);
  EXPECT_EQ(j.at("tests").at(0).at("kind"), "time_offset");
  EXPECT_EQ(j.at("tests").at(1).at("explained_by"), 0);
  EXPECT_TRUE(j.at("tests").at(1).at("sigmas").at(2).is_null());
  const std::string page = adjustment_page(report, {});
  EXPECT_NE(page.find("shadow of a time offset of the positions of FC6310"), std::string::npos);
  EXPECT_NE(page.find("not determined m"), std::string::npos);
  EXPECT_NE(page.find("0.0370 \xc2\xb1 0.0030 s"), std::string::npos);
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
  add(5, false, {9, 9, 9}, 0.01);  // control that was found wrong and rejected
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

// What lies on a table is known to micrometres: no standard deviation is printed as nothing.
TEST(WriteAdjustment, MicrometresAreShown) {
  AdjustmentReport report;
  report.block.control[{1}] = {.name = "P1", .role = ControlRole::kCheck, .sigma_m = {1e-6, 1e-6, 2e-6}};
  ControlDifference& one = report.adjusted.control.emplace_back();
  one.point = {1};
  one.difference_m = {-2.4e-6, 1.3e-6, 7e-6};
  one.difference_sigma_m = {3.4e-6, 2.9e-6, 8.1e-6};
  report.adjusted.points = {{{7}, {0, 0, 0}}};
  report.adjusted.point_covariance.push_back(Eigen::Vector3d(1e-12, 1e-12, 2.56e-12).asDiagonal());
  report.adjusted.pose_covariance[{1}] = Matrix6d::Identity() * 2.25e-12;
  report.block.images[{1}] = {"a.jpg", CameraId{1}, "", {}, {}, 1};
  report.adjusted.auxiliaries.push_back({.kind = UnknownKind::kLeverArm, .owner = 1, .value = 0.001, .sigma = 4.4e-6});
  report.block.cameras[{1}] = ideal_camera(1000, 1200, 900);
  report.adjusted.reliability.emplace();
  report.adjusted.reliability->left_out.push_back({{1}, one.difference_m, one.difference_sigma_m});
  const std::string page = adjustment_page(report, {});
  for (const char* shown : {"-0.0000024<", "+0.0000070<", ">0.0000034<", ">0.0000029<", ">0.0000081<", ">0.0000016<",
                            ">0.0000015<", ">0.0000044<"})
    EXPECT_NE(page.find(shown), std::string::npos) << shown;
  EXPECT_EQ(page.find(">0.0000<"), std::string::npos);
}

AdjustmentReport report_of_two_images() {
  AdjustmentReport report;
  report.block.cameras[{1}] = ideal_camera(1500, 2000, 1500);
  report.block.cameras[{1}].name = "lens";
  for (std::uint32_t i = 1; i <= 3; ++i) {
    report.block.images[{i}] = {"IMG_" + std::to_string(i) + ".jpg", {1}, "", {}, {}, 1};
    Matrix6d covariance = Matrix6d::Identity() * 1e-4;
    covariance(3, 1) = covariance(1, 3) = 0.5e-4 + 0.1e-4 * i;  // east with the turn about north
    if (i == 3) covariance.bottomRightCorner<3, 3>() *= 100;
    report.adjusted.pose_covariance[{i}] = covariance;
  }
  MatrixPd covariance = MatrixPd::Zero(Camera::kParams, Camera::kParams);
  covariance(Camera::kF, Camera::kF) = 4;
  covariance(Camera::kK1, Camera::kK1) = 1e-6;
  covariance(Camera::kF, Camera::kK1) = covariance(Camera::kK1, Camera::kF) = -0.95 * 2e-3;
  report.adjusted.camera_covariance[{1}] = covariance;
  for (const int param : {Camera::kF, Camera::kK1})
    for (int i = 0; i < 6; ++i)
      report.adjusted.camera_pose_correlations.push_back(
          {{1}, param, i, {2}, param == Camera::kF && i == 5 ? -0.97 : 0.01 * i});
  report.adjusted.points = {{{7}, {0, 0, 0}}, {{8}, {1, 0, 0}}, {{9}, {2, 0, 0}}};
  for (const double sigma : {0.01, 0.2, 0.01})
    report.adjusted.point_covariance.push_back(Eigen::Vector3d(1e-6, 1e-6, sigma * sigma).asDiagonal());
  report.block.observations = {{{1}, {8}, 0, {5, 5}, 1}, {{2}, {8}, 0, {5, 5}, 1}};
  report.adjusted.observations = {0, 1};
  report.adjusted.residuals_px = {{0, 0}, {0, 0}};
  return report;
}

TEST(WriteAdjustment, TheStrongestCorrelationsAreNamed) {
  const AdjustmentReport report = report_of_two_images();
  const std::string page = adjustment_page(report, {});
  EXPECT_NE(page.find("lens: strongest between k1 and f, -0.950"), std::string::npos);
  EXPECT_NE(page.find("strongest: f and the height of IMG_2.jpg (-0.97); k1 and the height of "), std::string::npos);
  EXPECT_NE(page.find("rotation about north, east</td><td>0.60</td><td>+0.700</td><td class=\"l\">IMG_2.jpg"),
            std::string::npos);
  const auto json = nlohmann::json::parse(adjustment_json(report));
  EXPECT_EQ(json.at("camera_pose_correlations").size(), 12u);
  EXPECT_EQ(json.at("camera_pose_correlations").at(5).at("of_pose"), "height");
  EXPECT_EQ(json.at("camera_pose_correlations").at(5).at("correlation"), -0.97);
  const auto& poses = json.at("pose_correlations");
  EXPECT_EQ(poses.at("pairs").size(), 15u);
  for (std::size_t k = 0; k < 15; ++k)
    EXPECT_NEAR(poses.at("images").at(0).at("correlations").at(k).get<double>(),
                poses.at("pairs").at(k) == nlohmann::json({"rotation about north", "east"}) ? 0.6 : 0, 1e-12);
}

// A turn of the world about north is one of phi the other way: both are stated, and which is which.
TEST(WriteAdjustment, CorrelationsWithOmegaPhiKappaHaveTheirOwnSign) {
  AdjustmentReport report = report_of_two_images();
  for (const auto& [id, image] : report.block.images)
    set_pose(report.block, id, {cam_from_world(OmegaPhiKappa{}), {0, 0, 100}});
  report.adjusted.camera_pose_correlations.push_back({{1}, Camera::kF, 7, {2}, 0.91});
  const auto json = nlohmann::json::parse(adjustment_json(report));
  const auto& poses = json.at("pose_correlations");
  EXPECT_NE(poses.at("sense").get<std::string>().find("world before the camera"), std::string::npos);
  for (std::size_t k = 0; k < 15; ++k) {
    EXPECT_NEAR(poses.at("images").at(0).at("correlations").at(k).get<double>(),
                poses.at("pairs").at(k) == nlohmann::json({"rotation about north", "east"}) ? 0.6 : 0, 1e-12);
    EXPECT_NEAR(poses.at("images").at(0).at("correlations_with_angles").at(k).get<double>(),
                poses.at("pairs_with_angles").at(k) == nlohmann::json({"phi", "east"}) ? -0.6 : 0, 1e-12);
  }
  EXPECT_EQ(json.at("camera_pose_correlations").back().at("of_pose"), "phi");
  const std::string page = adjustment_page(report, {});
  EXPECT_NE(page.find("rotation about north, east</td><td>0.60</td><td>+0.700</td>"), std::string::npos);
  EXPECT_NE(page.find("phi, east</td><td>0.60</td><td>-0.700</td>"), std::string::npos);
}

// Two points in two images and one in three, of which each ray has a redundancy number of its own.
AdjustmentReport report_of_small_network() {
  AdjustmentReport report = report_of_two_images();
  report.block.observations.clear();
  report.adjusted.observations.clear();
  report.adjusted.residuals_px.clear();
  report.adjusted.reliability.emplace();
  for (const auto& [point, images] : std::map<std::uint32_t, std::uint32_t>{{7, 2}, {8, 2}, {9, 3}})
    for (std::uint32_t image = 1; image <= images; ++image) {
      set_pose(report.block, {image}, {});
      report.adjusted.cam_from_world[{image}] = {};
      report.adjusted.observations.push_back(std::uint32_t(report.block.observations.size()));
      report.block.observations.push_back({{image}, {point}, 0, {5, 5}, 1});
      report.adjusted.residuals_px.emplace_back(0.3, 0.4);
      report.adjusted.reliability->tie_redundancy.emplace_back(0.1 * images, 0.2 * images);
    }
  report.adjusted.positions = {{{2}, {0.1, 0.2, 0.3}, 0.5}};
  report.adjusted.observation_count = 14;
  report.adjusted.unknown_count = 18 + 9 + 2;
  report.adjusted.rank_defect = 7;
  return report;
}

TEST(WriteAdjustment, TheNetworkIsCountedByKindAndByRays) {
  const AdjustmentReport report = report_of_small_network();
  const auto network = nlohmann::json::parse(adjustment_json(report)).at("network");
  EXPECT_EQ(network.at("unknowns_of"),
            nlohmann::json({{"images", 18}, {"tie_points", 9}, {"cameras", 2}, {"others", 0}}));
  ASSERT_EQ(network.at("tie_points").size(), 2u);
  const auto& two = network.at("tie_points").at(0);
  EXPECT_EQ(two.at("images"), 2);
  EXPECT_EQ(two.at("points"), 2);
  EXPECT_EQ(two.at("rays"), 4);
  EXPECT_EQ(two.at("observations"), 8);
  EXPECT_EQ(two.at("unknowns"), 6);
  EXPECT_NEAR(two.at("redundancy").get<double>(), 4 * (0.2 + 0.4), 1e-12);
  EXPECT_NEAR(network.at("tie_points").at(1).at("mean_redundancy_number").get<double>(), 0.45, 1e-12);
  const auto& map = network.at("map");
  EXPECT_EQ(map.at("rows"), 1);
  EXPECT_NEAR(map.at("mean_redundancy_number").at(0).get<double>(), 0.3, 1e-12);
  EXPECT_NEAR(map.at("mean_redundancy_number").back().get<double>(), 0.45, 1e-12);
  EXPECT_TRUE(map.at("mean_redundancy_number").at(1).is_null());
  const std::string page = adjustment_page(report, {});
  EXPECT_NE(page.find("m = 14 observations, n = 29 unknowns, rank defect d = 7"), std::string::npos);
  EXPECT_NE(page.find("in 3 images"), std::string::npos);
  EXPECT_NE(page.find("Local redundancy"), std::string::npos);
}

TEST(WriteAdjustment, EveryImageAndCameraIsInTheFigures) {
  const AdjustmentReport report = report_of_small_network();
  const auto json = nlohmann::json::parse(adjustment_json(report));
  const auto& image = json.at("image_list").at(1);
  EXPECT_EQ(image.at("file"), "IMG_2.jpg");
  EXPECT_EQ(image.at("rays"), 3);
  EXPECT_NEAR(image.at("rms_px").get<double>(), 0.5, 1e-12);
  EXPECT_NEAR(image.at("centre_sigma_m").at(2).get<double>(), 0.01, 1e-12);
  EXPECT_NEAR(image.at("rotation_sigma_deg").at(0).get<double>(), 0.57295779513, 1e-9);
  EXPECT_NEAR(image.at("position_weight").get<double>(), 0.5, 1e-12);
  const auto& camera = json.at("cameras").at(0);
  EXPECT_EQ(camera.at("images"), 3);
  EXPECT_EQ(camera.at("rays"), 7);
  EXPECT_NEAR(camera.at("parameters").at("f").at("sigma").get<double>(), 2, 1e-12);
  EXPECT_EQ(camera.at("parameters").at("cx").at("sigma"), 0);
  EXPECT_NEAR(camera.at("correlations").at("k1").at("f").get<double>(), -0.95, 1e-12);
}

// One long sentence had pushed all values of the first table out of the page.
TEST(WriteAdjustment, TheFirstTableBreaksItsSentences) {
  AdjustmentReport report = report_of_two_images();
  report.adjusted.conditioning.inflation = 1e9;
  const std::string page = adjustment_page(report, {});
  const auto sentence = page.find("the worst combination of unknowns");
  ASSERT_NE(sentence, std::string::npos);
  const auto from = page.rfind("<td", sentence);
  EXPECT_EQ(page.substr(from, sentence - from), "<td class=\"l w\">");
}

TEST(WriteAdjustment, TheWeakestImagesAndPointsComeFirst) {
  const auto weakest = nlohmann::json::parse(adjustment_json(report_of_two_images())).at("weakest");
  EXPECT_EQ(weakest.at("images").at("weak"), 1);
  EXPECT_EQ(weakest.at("images").at("worst").at(0).at("name"), "IMG_3.jpg");
  EXPECT_NEAR(weakest.at("images").at("worst").at(0).at("times_the_median").get<double>(), 10, 1e-9);
  const auto& point = weakest.at("points").at("worst").at(0);
  EXPECT_EQ(point.at("name"), "8");
  EXPECT_EQ(point.at("measurements"), 2);
  EXPECT_NEAR(point.at("sigma_m").get<double>(), 0.2, 1e-12);
}

TEST(WriteAdjustment, WhatNoImageSeesIsCounted) {
  AdjustmentReport report;
  report.adjusted.reliability.emplace().unseen = 3;
  EXPECT_NE(
      adjustment_page(report, {}).find("3 measurements are of points that lie where their image does not see them"),
      std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(adjustment_json(report)).at("reliability").at("unseen"), 3);
}

TEST(WriteAdjustment, ControlLeftOutInPartsIsStated) {
  AdjustmentReport report;
  report.block.control[{1}].name = "gcp1";
  report.block.control[{2}].name = "gcp2";
  Folded& folded = report.adjusted.reliability.emplace().folded;
  folded.folds = 2;
  folded.part = {1, 2};
  folded.points = {{{1}, {0.03, 0.04, 0.01}, {0.05, 0.05, 0.02}}, {{2}, {0.03, 0.04, 0.07}, {0.05, 0.05, 0.02}}};
  const std::string page = adjustment_page(report, {});
  EXPECT_NE(page.find("Control in 2 parts"), std::string::npos);
  EXPECT_NE(page.find("Plan: root mean square 0.0500 m over 2 points, predicted 0.0707 m"), std::string::npos);
  const auto parts = nlohmann::json::parse(adjustment_json(report)).at("reliability").at("left_out_in_parts");
  EXPECT_EQ(parts.at("points").at(1).at("part"), 2);
  EXPECT_NEAR(parts.at("rms").at("height").at("rms_m").get<double>(), 0.05, 1e-12);
}

TEST(WriteAdjustment, WhatWasRejectedOfGroundAndAttitudesIsStatedInDegrees) {
  Block block;
  block.images[{1}].file = "IMG_1.jpg";
  block.control[{1}].name = "A";
  block.control[{2}].name = "B";
  block.geodetic = {{.kind = GeodeticKind::kZenithAngle, .from = {1}, .to = {2}}};
  Rejected angle{ObservationGroup::kZenithAngle};
  angle.gross_error.x() = 0.01;
  angle.sigma = 1e-4;
  angle.w = 100;
  EXPECT_EQ(words_of_rejected(angle, block),
            "zenith angle A - B, off by 0.5730 deg (measured +0.5730 deg with a sigma of 0.00573 deg)");
  Rejected heading{ObservationGroup::kAttitudeHeading, {1}};
  heading.axis = 2;
  heading.gross_error.z() = -0.01;
  heading.sigma = 1e-4;
  heading.w = 100;
  EXPECT_EQ(
      words_of_rejected(heading, block),
      "attitude of IMG_1.jpg, heading, off by 0.5730 deg (about the plumb line -0.5730 deg with a sigma of 0.00573 "
      "deg)");
}

}  // namespace
}  // namespace collinea
