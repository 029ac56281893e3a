// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/step_job.h"

#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/serve/project_json.h"
#include "collinea/steps/test_small_project.h"

namespace collinea {
namespace {

using nlohmann::json;

class StepJob : public SmallProject {};

TEST_F(StepJob, AStepIsDoneWithOptionsAndShown) {
  map(Step::kImport);
  const ServedProject project{"7", "mapped", root_ / "mapped"};
  Log log;
  std::vector<std::string> stages;
  collinea::Run run = log.run();
  run.progress = [&](std::string_view stage, double) { stages.emplace_back(stage); };
  const auto findings = run_step_job({project, Step::kDetect, R"({"verify": {"min_inliers": 20}})"}, run);
  ASSERT_TRUE(findings) << findings.error().message;
  EXPECT_TRUE(json::parse(*findings).is_array());
  EXPECT_EQ(log.steps_done(), std::vector<std::string>{"detect"});
  EXPECT_EQ(stages.front(), "detect");
  EXPECT_EQ(read_settings(project.folder)->verify.min_inliers, 20);
  EXPECT_NE(read_file(project.folder / "log.txt").value_or("").find("detect"), std::string::npos);

  const auto text = project_json(project);
  ASSERT_TRUE(text) << text.error().message;
  const json shown = json::parse(*text);
  EXPECT_EQ(shown.at("images"), 6);
  EXPECT_EQ(shown.at("steps").size(), std::size(kStepWords));
  for (const json& step : shown.at("steps")) {
    const bool done = step.at("name") == "import" || step.at("name") == "detect";
    EXPECT_EQ(step.at("done"), done) << step;
    EXPECT_EQ(step.contains("summary"), done) << step;
  }

  // Who works on the project keeps others out; what is asked wrongly changes nothing.
  {
    const auto at_work = create_project(project.folder, *read_settings(project.folder), {});
    ASSERT_TRUE(at_work);
    const auto kept_out = run_step_job({project, Step::kDetect}, {});
    ASSERT_FALSE(kept_out);
    EXPECT_NE(kept_out.error().message.find("another collinea is at work"), std::string::npos)
        << kept_out.error().message;
  }
  const auto wrong = run_step_job({project, Step::kDetect, R"({"verify": {"min_inliers": 1}})"}, {});
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("min_inliers = 1 is out of range"), std::string::npos) << wrong.error().message;
  EXPECT_EQ(read_settings(project.folder)->verify.min_inliers, 20);
}

TEST(ProjectJson, AProjectWithoutDatabaseIsShownEmpty) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "collinea_empty_project";
  std::filesystem::create_directories(folder);
  const auto text = project_json({"7", "empty", folder});
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(json::parse(*text).at("images"), 0);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace collinea
