// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/adjust_project.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "collinea/image/test_folder.h"
#include "collinea/pipeline/test_project.h"

namespace collinea {
namespace {

TEST(AdjustProject, WritesReportAndTablesAndLeavesTheProjectAsItIs) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 12;
  survey.control_points = 6;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 120});
  ASSERT_TRUE(project) << project.error().message;
  const auto early = adjust_project(*project, {});
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().code, Errc::kNotFound);
  ASSERT_TRUE(bring_up_to(*project, "orient"));
  const Block before = *project->store.read_block();

  for (const bool components : {false, true}) {
    const auto done = adjust_project(*project, {.variance_components = components});
    ASSERT_TRUE(done) << done.error().message;
    std::ifstream file(folder / "block" / "adjustment" / "adjustment.json");
    const nlohmann::json report = nlohmann::json::parse(file);
    // Orientation left sigmas as the residuals show them: sigma0 is 1 within four of its standard deviations
    // (chi-squared with the redundancy); variance components are repeated until 1 %.
    const double bound = components ? 0.01 : 4 / std::sqrt(2 * report.at("redundancy").get<double>());
    EXPECT_NEAR(report.at("sigma0").get<double>(), 1, bound);
    EXPECT_LT(bound, 0.1);
    EXPECT_FALSE(report.at("control_points").empty());
    EXPECT_TRUE(report.at("control_points").at(0).at("sigma_m").at(2).is_number());
    EXPECT_FALSE(report.at("reliability").at("groups").empty());
    EXPECT_EQ(report.at("reliability").at("groups").at(0).contains("applied_factor"), components);
  }
  for (const char* name :
       {"poses.csv", "cameras.csv", "points.csv", "control.csv", "observations.csv", "suspects.csv", "adjustment.html"})
    EXPECT_GT(std::filesystem::file_size(folder / "block" / "adjustment" / name), 20u) << name;
  const Block after = *project->store.read_block();
  for (const auto& [id, pose] : before.cam_from_world)
    EXPECT_EQ(pose.translation, after.cam_from_world.at(id).translation);
}

TEST(AdjustProject, RefusesAnUnknownCalibration) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 6;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 80});
  ASSERT_TRUE(project && bring_up_to(*project, "orient"));
  const auto done = adjust_project(*project, {.calibration = "everything"});
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
