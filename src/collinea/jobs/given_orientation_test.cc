// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/given_orientation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>

#include "collinea/base/test_folder.h"
#include "collinea/io/colmap.h"
#include "collinea/jobs/export.h"
#include "collinea/project/project.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/simulated_project.h"

namespace collinea {
namespace {

Project opened(const std::filesystem::path& folder, const std::function<void(Settings&)>& change = {}) {
  auto settings = read_settings(folder);
  EXPECT_TRUE(settings) << settings.error().message;
  if (change) change(*settings);
  auto project = create_project(folder, *settings, {});
  EXPECT_TRUE(project) << project.error().message;
  return std::move(*project);
}

class GivenOrientationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    SurveyOptions survey;
    survey.images = 12;
    survey.control_points = 4;
    ASSERT_TRUE(simulate_project(survey, {.points_per_image = 120}, folder_ / "block", {}));
    Project project = opened(folder_ / "block");
    const auto done = bring_up_to(project, Step::kOrient);
    ASSERT_TRUE(done) << done.error().message;
    block_ = *project.store.read_block();
    for (const ExportFormat format : {ExportFormat::kColmap, ExportFormat::kBundler, ExportFormat::kOpk})
      ASSERT_TRUE(export_block(project, folder_ / std::string(word_of(format)), {.format = format})) << word_of(format);
  }

  Block oriented_from(const std::filesystem::path& given) {
    Project project =
        opened(folder_ / "block", [&](Settings& settings) { settings.orient.orientation = given.string(); });
    const auto done = bring_up_to(project, Step::kOrient);
    EXPECT_TRUE(done) << done.error().message;
    const auto record = project.store.read_outcome<OrientationRecord>();
    EXPECT_TRUE(record && record->findings.front().subjects == std::vector{Subject::file(given.string())});
    EXPECT_EQ(record->findings.front().code, FindingCode::kOrientationFixed);
    return *project.store.read_block();
  }

  void expect_same_poses(const Block& block, double within_m, double within_rad) const {
    ASSERT_EQ(count_oriented(block), count_oriented(block_));
    for (const auto& [image, pose] : oriented_images(block)) {
      const Rigid3& exact = pose_of(block_, image);
      EXPECT_LT((centre_of(pose) - centre_of(exact)).norm(), within_m) << image.value;
      EXPECT_LT(pose.rotation.angularDistance(exact.rotation), within_rad) << image.value;
    }
  }

  std::string complaint(const std::filesystem::path& path) const {
    const auto read = read_orientation(path, block_);
    return read ? "" : read.error().message;
  }

  TestFolder folder_;
  Block block_;
};

TEST_F(GivenOrientationTest, ABlockThatWasExportedComesBackFromColmap) {
  const Block block = oriented_from(folder_ / "colmap");
  expect_same_poses(block, 1e-6, 1e-9);
  EXPECT_NEAR(double(block.points.size()), double(block_.points.size()), 0.02 * double(block_.points.size()));
  // The same rays: points move by what single rays taken or left make, a fraction of a pixel on the ground.
  std::map<std::pair<ImageId, std::uint32_t>, Eigen::Vector3d> position;
  for (const Observation& seen : block_.observations)
    position[{seen.image, seen.feature}] = block_.points.at(seen.point).position_in_world;
  std::vector<double> moved_m;
  for (const Observation& seen : block.observations)
    if (const auto before = position.find({seen.image, seen.feature}); before != position.end())
      moved_m.push_back((before->second - block.points.at(seen.point).position_in_world).norm());
  ASSERT_GT(moved_m.size(), block_.observations.size() * 95 / 100);
  std::sort(moved_m.begin(), moved_m.end());
  EXPECT_LT(moved_m[moved_m.size() * 9 / 10], 0.02);
}

TEST_F(GivenOrientationTest, ATableOfAnglesGivesPosesInTheMap) {
  expect_same_poses(oriented_from(folder_ / "opk" / "orientation.opk"), 1e-3, 1e-8);
}

TEST_F(GivenOrientationTest, BundlersFilesGivePosesAndCameras) {
  const auto read = read_orientation(folder_ / "bundler" / "bundle.out", block_);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->given.cam_from_world.size(), count_oriented(block_));
  EXPECT_NEAR(read->given.cameras.begin()->second.focal_px(), block_.cameras.begin()->second.focal_px(), 1e-6);
  EXPECT_TRUE(read->findings.empty());
}

TEST_F(GivenOrientationTest, ModelsOfSmallerImagesAreScaledAndOthersRefused) {
  Block small = block_;
  for (auto& [id, camera] : small.cameras) {
    camera.width_px /= 2, camera.height_px /= 2;
    for (const int param : {Camera::kF, Camera::kCx, Camera::kCy}) camera.params[std::size_t(param)] /= 2;
  }
  ASSERT_TRUE(write_colmap(folder_ / "small", small, ColmapEncoding::kText));
  const auto read = read_orientation(folder_ / "small", block_);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_NEAR(read->given.cameras.begin()->second.focal_px(), block_.cameras.begin()->second.focal_px(), 1e-6);
  small.cameras.begin()->second.width_px += 40;
  ASSERT_TRUE(write_colmap(folder_ / "other", small, ColmapEncoding::kText));
  EXPECT_NE(complaint(folder_ / "other").find("the photograph has"), std::string::npos);
}

TEST_F(GivenOrientationTest, WhatIsWrongIsNamedWithFileLineAndImage) {
  EXPECT_NE(complaint(folder_ / "nowhere").find("does not exist"), std::string::npos);
  EXPECT_NE(complaint(folder_ / "block").find("neither a COLMAP model"), std::string::npos);
  std::ofstream(folder_ / "table.txt") << "# image x y z o p k\nstranger.jpg 1 2 3 4 5 6\n";
  const std::string stranger = complaint(folder_ / "table.txt");
  EXPECT_NE(stranger.find("table.txt"), std::string::npos) << stranger;
  EXPECT_NE(stranger.find("stranger.jpg"), std::string::npos) << stranger;
  std::ofstream(folder_ / "torn.txt") << block_.images.begin()->second.file << " 1 2 3 4 5 6\nhalf a line\n";
  EXPECT_NE(complaint(folder_ / "torn.txt").find("line 2"), std::string::npos);
}

}  // namespace
}  // namespace collinea
