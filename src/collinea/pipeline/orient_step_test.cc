// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "collinea/image/test_folder.h"
#include "collinea/io/file.h"
#include "collinea/pipeline/info.h"
#include "collinea/pipeline/project.h"
#include "collinea/pipeline/simulated_project.h"
#include "collinea/pipeline/step.h"

namespace collinea {
namespace {

// A flight that orient can begin with, its setup to be spoilt.
class OrientStepTest : public testing::Test {
 protected:
  void SetUp() override {
    SurveyOptions survey;
    survey.images = 12;
    survey.control_points = 6;
    survey.check_points = 2;
    ASSERT_TRUE(simulate_project(survey, {.points_per_image = 120}, folder_ / "block", {}));
    auto settings = read_settings(folder_ / "block");
    ASSERT_TRUE(settings) << settings.error().message;
    auto project = create_project(folder_ / "block", *settings, {});
    ASSERT_TRUE(project) << project.error().message;
    project_ = *std::move(project);
    setup_ = *project_->store.read_setup();
  }
  void orient() {
    ASSERT_TRUE(project_->store.write_setup(setup_));
    const auto done = bring_up_to(*project_, "orient");
    ASSERT_TRUE(done) << done.error().message;
  }
  [[nodiscard]] nlohmann::json info() const { return nlohmann::json::parse(*info_json(project_->store)); }
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
  const auto listed = row(info().at("control_points"), wrong.name);
  EXPECT_EQ(listed.at("role"), "excluded");
  EXPECT_NEAR(listed.at("difference_m").at(0).get<double>(), -3, 0.2);
  EXPECT_GE(listed.at("images").get<int>(), 2);
  const auto told = report();
  EXPECT_EQ(row(told.at("control_points"), wrong.name).at("role"), "excluded");
  EXPECT_EQ(told.at("control_rmse_m").at("points"), 5);
  EXPECT_EQ(told.at("check_rmse_m").at("points"), 2);
}

}  // namespace
}  // namespace collinea
