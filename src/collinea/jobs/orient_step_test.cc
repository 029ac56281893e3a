// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/jobs/adjust_project.h"
#include "collinea/orient/flight_strips.h"
#include "collinea/orient/orient.h"
#include "collinea/report/finding_words.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/step.h"
#include "collinea/steps/test_project.h"

namespace collinea {
namespace {

// A flight that orient can begin with, its setup to be spoilt.
class OrientStepTest : public ::testing::Test {
 protected:
  void SetUp() override {
    SurveyOptions survey;
    survey.images = 12;
    survey.control_points = 6;
    survey.check_points = 2;
    auto project = open_simulated(folder_ / "block", survey, {.points_per_image = 120});
    ASSERT_TRUE(project) << project.error().message;
    project_ = *std::move(project);
    setup_ = *project_->store.read_setup();
  }
  void orient() {
    ASSERT_TRUE(project_->store.write_setup(setup_));
    const auto done = bring_up_to(*project_, Step::kAdjust);
    ASSERT_TRUE(done) << done.error().message;
  }
  [[nodiscard]] OrientationRecord record() const {
    const auto found = project_->store.read_outcome<OrientationRecord>();
    EXPECT_TRUE(found) << found.error().message;
    return *found;
  }
  [[nodiscard]] AdjustmentRecord adjustment() const {
    const auto found = project_->store.read_outcome<AdjustmentRecord>();
    EXPECT_TRUE(found) << found.error().message;
    return *found;
  }
  [[nodiscard]] bool finds(std::string_view words) const {
    std::vector<Finding> findings = record().findings;
    for (const Finding& more : adjustment().findings) findings.push_back(more);
    return std::any_of(findings.begin(), findings.end(),
                       [&](const Finding& one) { return sentence_of(one, setup_).find(words) != std::string::npos; });
  }
  [[nodiscard]] nlohmann::json report() {
    const auto written = report_step(*project_, "inputs");
    EXPECT_TRUE(written) << written.error().message;
    return nlohmann::json::parse(*read_file(folder_ / "block" / "report" / "report.json"));
  }
  static nlohmann::json row(const nlohmann::json& rows, const std::string& name) {
    for (const auto& row : rows)
      if (row.at("name") == name) return row;
    ADD_FAILURE() << "no row of " << name;
    return {};
  }

  TestFolder folder_;
  std::optional<Project> project_;
  Block setup_;
};

TEST_F(OrientStepTest, ControlThatWasFoundWrongIsInReportAndInfoWithWhatItIsOff) {
  ControlPoint& wrong = setup_.control.begin()->second;
  ASSERT_EQ(wrong.role, ControlRole::kControl);
  wrong.position_in_world.x() += 3;
  orient();
  const ControlDifference listed = adjustment().control.back();
  EXPECT_EQ(listed.point, setup_.control.begin()->first);
  EXPECT_TRUE(listed.excluded);
  EXPECT_NEAR(listed.difference_m.x(), -3, 0.2);
  EXPECT_GE(listed.rays, 2);
  const auto reported = report();
  EXPECT_EQ(row(reported.at("control_points"), wrong.name).at("role"), "excluded");
  EXPECT_EQ(reported.at("control_rmse_m").at("points"), 5);
  EXPECT_EQ(reported.at("check_rmse_m").at("points"), 2);
}

TEST_F(OrientStepTest, SigmasOfCentresAndCamerasAreTimesSigma0) {
  for (ControlObservation& seen : setup_.control_observations) seen.sigma_px *= 4;  // better than stated
  for (auto& [id, image] : setup_.images) image.position->sigma_m *= 2;
  orient();
  const double sigma0 = adjustment().sigma0;
  ASSERT_GT(std::abs(sigma0 - 1), 0.002);
  const auto covariances = project_->store.read_covariances();
  ASSERT_TRUE(covariances) << covariances.error().message;
  const auto reported = report();
  const auto& [image, pose] = *covariances->poses.begin();
  const auto& row = reported.at("image_list").at(0);
  ASSERT_EQ(row.at("file"), setup_.images.at(image).file);
  EXPECT_NEAR(row.at("centre_sigma_m").at(2).get<double>() / (sigma0 * std::sqrt(pose(5, 5))), 1, 1e-9);
  const Eigen::MatrixXd& camera = covariances->cameras.begin()->second;
  EXPECT_NEAR(reported.at("cameras").at(0).at("parameters").at("f").at("sigma").get<double>() /
                  (sigma0 * std::sqrt(camera(Camera::kF, Camera::kF))),
              1, 1e-9);
  const Block block = *project_->store.read_block();
  ASSERT_EQ(covariances->points.size(), block.points.size());
  for (const Eigen::Matrix3d& point : covariances->points) EXPECT_GT(point.determinant(), 0);
}

// No location on Earth, and control points that are only marked: what is measured between them tells the scale.
TEST_F(OrientStepTest, DistancesMakeABlockWithoutPositionMetric) {
  std::map<ControlId, Eigen::Vector3d> truth;
  for (auto& [id, point] : setup_.control) {
    truth[id] = point.position_in_world;
    point.role = ControlRole::kControl;
    point.position_in_world = point.position_in_map = Eigen::Vector3d::Zero();
    point.sigma_m.setConstant(std::numeric_limits<double>::infinity());
  }
  setup_.georeference.reset();
  for (auto& [id, image] : setup_.images) image.position.reset();
  const auto measure = [&](std::uint32_t from, std::uint32_t to, double error_m, ControlRole role) {
    const double length = (truth.at({from}) - truth.at({to})).norm();
    setup_.geodetic.push_back({.from = {from}, .to = {to}, .value = length + error_m, .sigma = 0.02, .role = role});
  };
  measure(0, 1, 0.01, ControlRole::kControl);
  measure(1, 2, -0.01, ControlRole::kControl);
  measure(2, 3, 10, ControlRole::kControl);  // a slip of the pen
  measure(3, 4, 0, ControlRole::kCheck);
  orient();
  const OrientationRecord reported = record();
  EXPECT_FALSE(reported.georeferenced);
  EXPECT_TRUE(reported.metric);
  EXPECT_TRUE(reported.gsd_m());
  EXPECT_EQ(reported.gauge.distances, 2u);
  EXPECT_TRUE(finds("contradicts the other distances"));
  const nlohmann::json shown = report();
  EXPECT_EQ(shown.at("length_unit"), "m");
  ASSERT_EQ(shown.at("geodetic").size(), 4u);
  EXPECT_EQ(shown.at("geodetic").at(2).at("role"), "excluded");
  const nlohmann::json& check = shown.at("geodetic").at(3);
  EXPECT_EQ(check.at("role"), "check");
  EXPECT_LT(std::abs(check.at("difference").get<double>()), 4 * check.at("sigma").get<double>());
  EXPECT_LT(check.at("sigma").get<double>(), 0.1);

  ASSERT_TRUE(try_adjustment(*project_, {}, folder_ / "trial"));
  const nlohmann::json adjusted = nlohmann::json::parse(*read_file(folder_ / "trial" / "adjustment.json"));
  ASSERT_EQ(adjusted.at("geodetic").size(), 4u);
  EXPECT_EQ(adjusted.at("geodetic").at(0).at("role"), "control");
  EXPECT_EQ(adjusted.at("geodetic").at(2).at("role"), "check");  // what orientation left out stays out
  EXPECT_NE(read_file(folder_ / "trial" / "geodetic.csv")->find("\"distance\",m,check"), std::string::npos);
}

// An antenna, a constant error of the receiver and a clock that is late, on a flight with precise positions.
class InstrumentsTest : public OrientStepTest {
 protected:
  void SetUp() override {
    SurveyOptions survey;
    survey.strips = 3;
    survey.images_per_strip = 5;
    survey.control_points = 6;
    survey.receiver.gps_sigma_plan_m = survey.receiver.gps_sigma_height_m = 0.02;
    auto project = open_simulated(folder_ / "block", survey, {.points_per_image = 120});
    ASSERT_TRUE(project) << project.error().message;
    project_ = *std::move(project);
    setup_ = *project_->store.read_setup();
    Block flown = setup_;
    for (auto& [id, image] : flown.images)
      set_pose(flown, id, {Eigen::Quaterniond::Identity(), -image.position->position_in_world});
    const auto velocities = flight_velocities(flown);
    for (auto& [id, image] : setup_.images) image.position->position_in_world += kShift + kOffset_s * velocities.at(id);
  }
  [[nodiscard]] nlohmann::json adjusted() {
    return nlohmann::json::parse(*read_file(folder_ / "trial" / "adjustment.json"));
  }
  static void expect_found(const nlohmann::json& unknowns) {
    int found = 0;
    for (const auto& row : unknowns) {
      const std::string name = row.at("unknown");
      const double value = row.at("value"), sigma = row.at("sigma");
      const auto expect = [&](const char* beginning, double truth) {
        if (!name.starts_with(beginning)) return;
        EXPECT_LT(std::abs(value - truth), 3 * sigma) << name << " " << value << " " << sigma;
        ++found;
      };
      expect("the shift of positions in east", kShift.x());
      expect("the shift of positions in north", kShift.y());
      expect("the shift of positions in height", kShift.z());
      expect("the time offset", kOffset_s);
    }
    EXPECT_EQ(found, 4);
  }

  static constexpr double kOffset_s = 0.05;
  static const Eigen::Vector3d kShift;
};
const Eigen::Vector3d InstrumentsTest::kShift(0.8, -0.5, 12);

TEST_F(InstrumentsTest, AreFoundByOrientAndTakenOverByAdjust) {
  project_->settings.orient.instruments.position_shift = PositionShift::kBlock;
  project_->settings.orient.instruments.time_offset = true;
  orient();
  EXPECT_TRUE(finds("The shift of positions of strip 1 is +0."));
  EXPECT_TRUE(finds("The time offset of positions of"));
  EXPECT_FALSE(finds("GPS heights lie"));  // that is the shift
  const auto done = try_adjustment(*project_, {}, folder_ / "trial");
  ASSERT_TRUE(done) << done.error().message;
  expect_found(adjusted().at("auxiliary_unknowns"));
  EXPECT_NEAR(adjusted().at("sigma0").get<double>(), 1, 0.1);
  // Without any of it: what orient found is left out, and the positions contradict.
  const auto without = try_adjustment(*project_,
                                      {.instruments = {.position_shift = PositionShift::kNone, .time_offset = false},
                                       .systematics = Systematics::kNone},
                                      folder_ / "trial");
  ASSERT_TRUE(without) << without.error().message;
  EXPECT_FALSE(adjusted().contains("auxiliary_unknowns"));
}

// Nobody asked for it: the residuals turn with the direction of flight.
TEST_F(InstrumentsTest, ATimeOffsetBeyondDoubtIsTakenUpAndOnlyNamedWhereThatIsWanted) {
  const auto time_offset = [&] {
    const nlohmann::json figures = adjusted();
    ASSERT_TRUE(figures.contains("auxiliary_unknowns"));
    for (const auto& row : figures.at("auxiliary_unknowns")) {
      if (!row.at("unknown").get<std::string>().starts_with("the time offset")) continue;
      EXPECT_LT(std::abs(row.at("value").get<double>() - kOffset_s), 3 * row.at("sigma").get<double>());
      return;
    }
    ADD_FAILURE() << "no time offset";
  };
  orient();
  // Cameras turn with the flight: an antenna behind the camera does the same.
  EXPECT_TRUE(finds("a time offset of the positions of"));
  EXPECT_TRUE(finds("It is estimated now."));
  EXPECT_TRUE(adjustment().instruments.time_offset || adjustment().instruments.lever_arm);
  ASSERT_TRUE(try_adjustment(*project_, {.instruments = {.time_offset = true}}, folder_ / "trial"));
  time_offset();
  const double sigma0 = adjusted().at("sigma0").get<double>();
  ASSERT_TRUE(try_adjustment(*project_, {.systematics = Systematics::kName}, folder_ / "trial"));
  EXPECT_FALSE(adjusted().contains("auxiliary_unknowns"));
  EXPECT_GT(adjusted().at("sigma0").get<double>(), sigma0);
  project_->settings.adjust.systematics = Systematics::kNone;
  ASSERT_TRUE(bring_up_to(*project_, Step::kAdjust));
  EXPECT_FALSE(finds("The residuals show"));
}

TEST_F(InstrumentsTest, AShiftNeedsControl) {
  project_->settings.orient.instruments.position_shift = PositionShift::kStrips;
  project_->settings.orient.use_control = false;
  orient();
  EXPECT_TRUE(finds("No control point separates a shift of the positions"));
  ASSERT_TRUE(try_adjustment(*project_, {.systematics = Systematics::kNone}, folder_ / "trial"));
  EXPECT_FALSE(
      adjusted().contains("auxiliary_unknowns"));  // adjust takes over what orient did, not what it was asked for
}

TEST_F(InstrumentsTest, WhatTheImagesDoNotSayIsRefusedBeforeAnyWork) {
  for (auto& [id, image] : setup_.images) image.taken.clear();
  ASSERT_TRUE(project_->store.write_setup(setup_));
  project_->settings.orient.instruments.time_offset = true;
  const auto done = bring_up_to(*project_, Step::kOrient);
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kBadInput);
  project_->settings.orient.instruments = {.position_drift = true};  // of no shift
  EXPECT_FALSE(validate_settings(project_->settings));
}

}  // namespace
}  // namespace collinea
