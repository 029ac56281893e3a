// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/project/project.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/flow.h"
#include "collinea/store/sqlite.h"

namespace collinea {
namespace {

void put_noise(const std::filesystem::path& path, std::uint64_t seed) {
  Random random(seed);
  Raster<std::uint8_t> image(96, 80, 1);
  for (std::uint8_t& value : image.data) value = std::uint8_t(random.below(256));
  std::filesystem::create_directories(path.parent_path());
  ASSERT_TRUE(write_jpeg(path, image, 90));
}

Result<Project> detected(const TestFolder& folder) {
  Settings settings;
  settings.photos = (folder / "photos").string();
  COLLINEA_TRY(Project project, create_project(folder / "project", settings, {}));
  COLLINEA_TRY(bring_up_to(project, Step::kDetect));
  return project;
}

// Marks the features of an image, so that one sees whether they were kept.
void mark(Project& project, std::uint32_t image, float strength) {
  const std::string made_from = project.store.features_done().value().at(ImageId{image});
  const Features marked{{Keypoint{.x = 1, .y = 1, .scale_px = 1, .strength = strength}}, {Descriptor{}}};
  ASSERT_TRUE(project.store.write_features(ImageId{image}, marked, made_from));
}

TEST(DetectStep, AnImageAddedOrTakenAwayLeavesTheOthersAlone) {
  const TestFolder folder;
  for (const char* file : {"b.jpg", "d.jpg"}) put_noise(folder / "photos" / file, std::uint64_t(file[0]));
  {
    auto project = detected(folder);
    ASSERT_TRUE(project) << project.error().message;
    mark(*project, 0, 100);
    mark(*project, 1, 101);
  }
  put_noise(folder / "photos/a.jpg", 1);
  put_noise(folder / "photos/c.jpg", 2);
  const auto features = [](const Project& project, std::uint32_t image) {
    return project.store.read_features(ImageId{image}).value();
  };
  {
    const auto project = detected(folder);
    ASSERT_TRUE(project) << project.error().message;
    EXPECT_EQ(features(*project, 1).keypoints.at(0).strength, 100);
    EXPECT_EQ(features(*project, 3).keypoints.at(0).strength, 101);
    for (const std::uint32_t image : {0u, 2u}) EXPECT_GT(features(*project, image).keypoints.size(), 5u) << image;
  }
  std::filesystem::remove(folder / "photos/a.jpg");
  std::filesystem::remove(folder / "photos/b.jpg");
  const auto project = detected(folder);
  ASSERT_TRUE(project) << project.error().message;
  EXPECT_GT(features(*project, 0).keypoints.size(), 5u);
  EXPECT_EQ(features(*project, 1).keypoints.at(0).strength, 101);
}

TEST(DetectStep, StoppedAndResumedItMakesOnlyWhatIsMissing) {
  const TestFolder folder;
  for (const char* file : {"a.jpg", "b.jpg", "c.jpg", "d.jpg", "e.jpg"})
    put_noise(folder / "photos" / file, std::uint64_t(file[0]));
  Settings settings;
  settings.photos = (folder / "photos").string();
  const auto detect = [&](const collinea::Run& run) -> Result<> {
    COLLINEA_TRY(Project project, create_project(folder / "project", settings, run));
    return bring_up_to(project, Step::kDetect);
  };
  std::stop_source stop;
  std::vector<std::string> lines;
  std::vector<double> progress;
  collinea::Run run{.stop = stop.get_token()};
  run.progress = [&](std::string_view stage, double done) {
    if (stage != "detect") return;
    progress.push_back(done);
    if (done >= 0.4) stop.request_stop();
  };
  run.log = [&](std::string_view line) { lines.emplace_back(line); };
  const auto stopped = detect(run);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Errc::kCancelled);
  EXPECT_EQ(progress, (std::vector<double>{0, 0.2, 0.4}));
  run.stop = {};
  progress.clear();
  ASSERT_TRUE(detect(run));
  EXPECT_EQ(progress, (std::vector<double>{0, 1.0 / 3, 2.0 / 3, 1, 1}));  // the last one by the step
  EXPECT_EQ(std::count(lines.begin(), lines.end(), "detect: 2 of 5 images kept from before"), 1);
}

TEST(DetectStep, AnImageRepairedIsDetectedAgain) {
  const TestFolder folder;
  for (const char* file : {"a.jpg", "b.jpg"}) put_noise(folder / "photos" / file, std::uint64_t(file[0]));
  {
    auto project = detected(folder);
    ASSERT_TRUE(project) << project.error().message;
    mark(*project, 0, 100);
    mark(*project, 1, 101);
  }
  put_noise(folder / "photos/b.jpg", 7);
  const auto project = detected(folder);
  ASSERT_TRUE(project) << project.error().message;
  EXPECT_EQ(project->store.read_keypoints(ImageId{0}).value().size(), 1u);
  EXPECT_GT(project->store.read_keypoints(ImageId{1}).value().size(), 5u);
}

TEST(DetectStep, AFullDiskEndsItAtOnce) {
  const TestFolder folder;
  for (const char* file : {"a.jpg", "b.jpg", "c.jpg", "d.jpg"})
    put_noise(folder / "photos" / file, std::uint64_t(file[0]));
  Settings settings;
  settings.photos = (folder / "photos").string();
  int reported = 0;
  collinea::Run run;
  run.progress = [&](std::string_view stage, double done) { reported += stage == "detect" && done > 0; };
  auto project = create_project(folder / "project", settings, run);
  ASSERT_TRUE(project) << project.error().message;
  {
    auto database = sqlite::Database::open(folder / "project/block.db");
    ASSERT_TRUE(database && database->execute("CREATE TRIGGER full BEFORE INSERT ON features BEGIN "
                                              "SELECT RAISE(FAIL, 'the disk is full'); END"));
  }
  const auto done = bring_up_to(*project, Step::kDetect);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("the disk is full"), std::string::npos) << done.error().message;
  EXPECT_EQ(reported, 0);
}

}  // namespace
}  // namespace collinea
