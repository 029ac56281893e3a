// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/adjust_project.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "collinea/base/test_folder.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"

namespace collinea {
namespace {

TEST(AdjustProject, ATrialWritesReportAndTablesAndLeavesTheProjectAsItIs) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project) << project.error().message;
  const std::filesystem::path out = folder / "trial";
  const auto early = try_adjustment(*project, {}, out);
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().code, Errc::kNotFound);
  ASSERT_TRUE(bring_up_to(*project, Step::kOrient));
  const Block before = *project->store.read_block();

  for (const bool components : {false, true}) {
    const auto done = try_adjustment(*project, {.variance_components = components}, out);
    ASSERT_TRUE(done) << done.error().message;
    const nlohmann::json report = report_in(out);
    EXPECT_EQ(report.at("sigma0").get<double>(), done->adjusted.sigma0);
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
    EXPECT_GT(std::filesystem::file_size(out / name), 20u) << name;
  const Block after = *project->store.read_block();
  EXPECT_FALSE(project->store.read_step("adjust")->has_value());
  EXPECT_FALSE(std::filesystem::exists(folder / "block" / "adjustment"));
  for (const auto& [id, pose] : oriented_images(before)) EXPECT_EQ(pose.translation, pose_of(after, id).translation);
}

// Gross errors in the oriented block of a project: they are rejected, reported, and do not spoil what is written.
TEST(AdjustProject, SnoopingTakesOutWhatIsWrongInAProject) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const auto report_of = [&](bool snoop) {
    const auto done =
        try_adjustment(*project, {.loss = Loss::kNone, .reject_mismatches = false, .snoop = snoop}, folder / "trial");
    EXPECT_TRUE(done) << done.error().message;
    return report_in(folder / "trial");
  };
  const double sigma0 = report_of(true).at("sigma0").get<double>();
  Block block = *project->store.read_block();
  std::map<PointId, int> rays;
  for (const Observation& seen : block.observations) ++rays[seen.point];
  std::vector<std::string> wrong;
  std::set<PointId> points;
  for (std::size_t i = 50; i < block.observations.size() && wrong.size() < 5; i += 20) {
    Observation& seen = block.observations[i];
    // Of two rays neither is known to be wrong, and along its base nothing checks the other of three.
    if (rays[seen.point] < 4 || !points.insert(seen.point).second) continue;
    seen.pixel.x() += 40 * seen.sigma_px;
    wrong.push_back("tie point " + std::to_string(seen.point.value) + " in " + block.images.at(seen.image).file);
  }
  ASSERT_EQ(wrong.size(), 5u);
  ASSERT_TRUE(project->store.write_orientation(block));
  EXPECT_FALSE(report_of(false).contains("snooping"));
  EXPECT_FALSE(std::filesystem::exists(folder / "trial" / "rejected.csv"));
  const nlohmann::json report = report_of(true);
  EXPECT_NEAR(report.at("sigma0").get<double>(), sigma0, 0.02 * sigma0);
  const nlohmann::json& snooping = report.at("snooping");
  EXPECT_TRUE(snooping.at("finished").get<bool>());
  EXPECT_GT(snooping.at("sigma0_before").get<double>(), 1.05 * sigma0);
  std::ifstream file(folder / "trial" / "rejected.csv");
  const std::string table{std::istreambuf_iterator<char>(file), {}};
  for (const std::string& name : wrong) {
    EXPECT_NE(table.find(name), std::string::npos) << name;
    bool reported = false;
    for (const auto& rejected : snooping.at("rejected")) reported |= rejected.at("observation") == name;
    EXPECT_TRUE(reported) << name;
  }
}

// Poses, cameras and points of the project are those of the step, whatever was adjusted before.
TEST(AdjustStep, IsTheProjectsAndBeginsWhereOrientationEnded) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const Block found = *project->store.read_block();
  ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  const auto record = project->store.read_outcome<AdjustmentRecord>();
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_EQ(record->images, count_oriented(found));
  EXPECT_GT(record->redundancy, 0);
  EXPECT_TRUE(record->control_rmse_m && record->position_rms_m);
  EXPECT_EQ(report_in(folder / "block" / "adjustment").at("sigma0").get<double>(), record->sigma0);
  const Block adjusted = *project->store.read_block();
  const ImageId image = oriented_images(found).front().image;
  EXPECT_NE(pose_of(found, image).translation, pose_of(adjusted, image).translation);
  const auto covariances = project->store.read_covariances();
  ASSERT_TRUE(covariances);
  EXPECT_EQ(covariances->poses.size(), count_oriented(adjusted));
  EXPECT_EQ(covariances->points.size(), adjusted.points.size());

  project->settings.adjust.use_control = false;
  ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  EXPECT_FALSE(project->store.read_outcome<AdjustmentRecord>()->control_rmse_m);
  EXPECT_NE(pose_of(*project->store.read_block(), image).translation, pose_of(adjusted, image).translation);
  EXPECT_EQ(pose_of(*project->store.read_found(), image).translation, pose_of(found, image).translation);
  project->settings.adjust.use_control = true;
  ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  EXPECT_EQ(pose_of(*project->store.read_block(), image).translation, pose_of(adjusted, image).translation);
}

TEST(AdjustProject, RefusesOptionsOutOfRange) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 6;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 80});
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const auto done = try_adjustment(*project, {.tests = {.folds = 1}}, folder / "trial");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kBadInput);
  EXPECT_EQ(done.error().options, std::vector{"folds"_option});
}

}  // namespace
}  // namespace collinea
