// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/simulated_project.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/compare/pose_errors.h"
#include "collinea/image/test_folder.h"
#include "collinea/pipeline/project.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

TEST(SimulatedProject, IsOrientedWithoutPhotographs) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 20;
  survey.control_points = 4;
  ASSERT_TRUE(simulate_project(survey, {.points_per_image = 120}, folder / "block", {}));

  std::vector<std::string> lines;
  collinea::Run run{.log = [&](std::string_view line) { lines.emplace_back(line); }};
  const auto settings = read_settings(folder / "block");
  ASSERT_TRUE(settings) << settings.error().message;
  auto project = create_project(folder / "block", *settings, run);
  ASSERT_TRUE(project) << project.error().message;
  const auto done = bring_up_to(*project, "orient");
  ASSERT_TRUE(done) << done.error().message;
  for (const char* step : {"import", "detect", "match"}) {
    const auto up_to_date = [&](const std::string& line) {
      return line.starts_with(step) && line.find("up to date") != std::string::npos;
    };
    EXPECT_EQ(std::count_if(lines.begin(), lines.end(), up_to_date), 1) << step;
  }
  const Block block = *project->store.read_block();
  const PoseErrors errors = pose_errors(block, read_truth(folder / "block")->cam_from_world, {});
  EXPECT_EQ(errors.oriented, 20u);
  ASSERT_TRUE(errors.after_similarity);
  EXPECT_LT(errors.after_similarity->rms_3d_m, 0.25);  // five pixels on the ground; the receivers are good to 1.5 m
}

}  // namespace
}  // namespace collinea
