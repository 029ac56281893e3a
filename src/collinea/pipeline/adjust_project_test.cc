// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/adjust_project.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "collinea/image/test_folder.h"
#include "collinea/io/file.h"
#include "collinea/io/text.h"
#include "collinea/pipeline/test_project.h"
#include "collinea/synthetic/write.h"

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

// Root mean square distance of the poses that were written from where the images truly are [m].
double rms_of_written_poses(const std::filesystem::path& project, const TruthFolder& truth) {
  std::ifstream file(project / "adjustment" / "poses.csv");
  std::string line;
  std::getline(file, line);
  double squares = 0, count = 0;
  while (std::getline(file, line)) {
    const auto fields = fields_of(line, ',');
    const std::string name(fields[0].substr(1, fields[0].size() - 2));
    const Eigen::Vector3d centre(*number(fields[1]), *number(fields[2]), *number(fields[3]));
    squares += (centre - truth.centre_in_map.at(name)).squaredNorm();
    ++count;
  }
  return std::sqrt(squares / count);
}

// Blunders of ten and more sigmas in a tie point, in a mark and in the height of a control point, too small for what
// looks at control before any adjustment: they are found and listed, they take no part
// in any table, and what is written is as near to the truth as it was without them.
TEST(AdjustProject, SnoopedBlundersAreListedAndTheProductsFollow) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 16;
  survey.control_points = 9;
  survey.check_points = 4;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 150, .wrong_share = 0});
  ASSERT_TRUE(project) << project.error().message;
  ASSERT_TRUE(bring_up_to(*project, "orient"));
  Block setup = *project->store.read_setup(), block = *project->store.read_block();
  const TruthFolder truth = *read_truth(folder / "block");
  const auto adjusted = [&](bool snoop) {
    const auto done = adjust_project(*project, {.loss = "none", .snoop = snoop});
    EXPECT_TRUE(done) << done.error().message;
    std::ifstream file(folder / "block" / "adjustment" / "adjustment.json");
    return nlohmann::json::parse(file);
  };
  adjusted(false);
  const double sound_m = rms_of_written_poses(folder / "block", truth);

  std::map<PointId, int> rays;
  for (const Observation& seen : block.observations) ++rays[seen.point];
  const auto tie = std::find_if(block.observations.begin(), block.observations.end(),
                                [&](const Observation& seen) { return rays.at(seen.point) >= 5; });
  ASSERT_NE(tie, block.observations.end());
  tie->pixel.x() += 25 * tie->sigma_px;
  ControlId in_height{}, marked{};
  for (const auto& [id, control] : setup.control) {
    const auto marks = std::count_if(setup.control_observations.begin(), setup.control_observations.end(),
                                     [id = id](const ControlObservation& seen) { return seen.point == id; });
    if (control.role != ControlRole::kControl || marks < 4) continue;
    (in_height.valid() ? marked : in_height) = id;
  }
  ASSERT_TRUE(in_height.valid() && marked.valid());
  for (Block* one : {&setup, &block}) {
    one->control.at(in_height).position_in_world.z() += 0.15;
    one->control.at(in_height).position_in_map.z() += 0.15;
    const auto mark = std::find_if(one->control_observations.begin(), one->control_observations.end(),
                                   [&](const ControlObservation& seen) { return seen.point == marked; });
    mark->pixel.y() += 2.5;
  }
  const ImageId marked_in =
      std::find_if(setup.control_observations.begin(), setup.control_observations.end(), [&](const auto& seen) {
        return seen.point == marked;
      })->image;
  ASSERT_TRUE(project->store.write_setup(setup));
  ASSERT_TRUE(project->store.write_orientation(block));

  adjusted(false);
  EXPECT_FALSE(std::filesystem::exists(folder / "block" / "adjustment" / "taken_out.csv"));
  const nlohmann::json report = adjusted(true);
  const double snooped_m = rms_of_written_poses(folder / "block", truth);
  EXPECT_LT(snooped_m, 1.2 * sound_m);

  const std::string file_of_tie = block.images.at(tie->image).file;
  const std::string wanted[] = {"tie point " + std::to_string(tie->point.value) + " in " + file_of_tie,
                                block.control.at(marked).name + " in " + block.images.at(marked_in).file,
                                block.control.at(in_height).name + ", height"};
  const auto& gone = report.at("snooping").at("taken_out");
  const std::string table = *read_file(folder / "block" / "adjustment" / "taken_out.csv"),
                    page = *read_file(folder / "block" / "adjustment" / "adjustment.html");
  for (const std::string& name : wanted) {
    const auto its = std::find_if(gone.begin(), gone.end(),
                                  [&](const nlohmann::json& one) { return one.at("observation") == name; });
    ASSERT_NE(its, gone.end()) << name << " " << gone.dump(1);
    EXPECT_NE(table.find(name), std::string::npos);
    EXPECT_NE(page.find(name), std::string::npos);
  }
  EXPECT_TRUE(report.at("snooping").at("finished").get<bool>());
  for (const auto& suspect : report.at("reliability").at("suspects"))
    for (const std::string& name : wanted) EXPECT_NE(suspect.at("observation").get<std::string>().find(name), 0u);
  for (const auto& point : report.at("control_points")) {
    const auto& difference = point.at("difference_m").at(2);
    if (point.at("name") == block.control.at(in_height).name) {
      EXPECT_NEAR(difference.get<double>(), -0.15, 0.08);  // it is still told what it differs by
    }
  }
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
