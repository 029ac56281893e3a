// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "collinea/project/project.h"
#include "collinea/steps/flow.h"
#include "collinea/synthetic/write.h"

namespace collinea {

/// What a run says, and so which steps it has done.
struct Log {
  std::vector<std::string> lines;

  [[nodiscard]] Run run(int threads = 1) {
    return {.log = [this](std::string_view line) { lines.emplace_back(line); }, .threads = threads};
  }
  [[nodiscard]] std::vector<std::string> steps_done() const {
    std::vector<std::string> done;
    for (const Word<Step>& step : kStepWords)
      for (const std::string& line : lines)
        if (line.starts_with(std::string(step.word) + " ") && line.find("up to date") == std::string::npos)
          done.emplace_back(step.word);
    return done;
  }
};

/// Six small images of a made-up village, mapped up to `last`. Tests are run one by one, each in a process of its
/// own: what follows on a mapping is therefore one test, made of many small ones.
class SmallProject : public ::testing::Test {
 public:
  static void map(Step last) {
    root_ = std::filesystem::path(::testing::TempDir()) / ("collinea_SmallProject_" + std::to_string(::getpid()));
    std::filesystem::remove_all(root_);
    SurveyOptions options;
    options.strips = 2;
    options.images_per_strip = 3;
    options.cross_strips = 0;
    options.camera.width_px = 400;
    options.camera.height_px = 300;
    options.gsd_m = 0.2;
    options.camera.principal_x_px = options.camera.principal_y_px = 1;
    options.control_points = 4;
    options.check_points = 2;
    options.receiver.gps_sigma_plan_m = 0.5;
    const auto truth = make_survey(options);
    ASSERT_TRUE(truth) << truth.error().message;
    std::filesystem::create_directories(root_ / "images");
    const auto images = write_images(*truth, root_ / "images", {.threads = 2});
    ASSERT_TRUE(images) << images.error().message;
    ASSERT_TRUE(write_tables(*truth, root_));
    Log log;
    const auto done = bring(root_ / "mapped", settings(), log, last);
    ASSERT_TRUE(done) << done.error().message;
    std::vector<std::string> wanted;
    for (const Word<Step>& step : kStepWords)
      if (step.value <= last) wanted.emplace_back(step.word);
    EXPECT_EQ(log.steps_done(), wanted);
  }
  void TearDown() override {
    std::error_code ignored;
    std::filesystem::remove_all(root_, ignored);
  }

  static Settings settings() {
    Settings settings;
    settings.photos = (root_ / "images").string();
    settings.import.control = (root_ / "control.csv").string();
    settings.pairs.exhaustive_below = 0;  // partners are chosen as in a large block
    return settings;
  }

  static Result<> bring(const std::filesystem::path& folder, const Settings& settings, Log& log, Step last,
                        int threads = 1) {
    COLLINEA_TRY(Project project, create_project(folder, settings, log.run(threads)));
    return bring_up_to(project, last);
  }

  /// A copy of the mapped project that a test may change.
  static std::filesystem::path copy(const std::string& name) {
    std::filesystem::copy(root_ / "mapped", root_ / name, std::filesystem::copy_options::recursive);
    return root_ / name;
  }

  static inline std::filesystem::path root_;
};

}  // namespace collinea
