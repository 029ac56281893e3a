// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/stereo_pair.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/cloud/ply.h"
#include "collinea/io/colmap.h"
#include "collinea/math/random.h"
#include "collinea/project/project.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

constexpr int kWidth = 240, kHeight = 160;
constexpr double kFocal_px = 200, kBase_m = 0.5, kDepth_m = 5;  // disparity 20

// A textured wall parallel to both cameras.
GreyImage wall(double shift_px) {
  Random random(12);
  GreyImage dots(kWidth + 60, kHeight), image(kWidth, kHeight);
  for (auto& grey : dots.data) grey = std::uint8_t(40 + random.below(180));
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      image.at(x, y) = std::uint8_t((dots.at(x + int(shift_px), y) + dots.at(x + int(shift_px) + 1, y)) / 2);
  return image;
}

struct StereoImages {
  TestFolder folder;
  std::string left = (folder / "photos/left.png").string(), right = (folder / "photos/right.png").string();

  StereoImages() {
    std::filesystem::create_directories(folder / "photos");
    EXPECT_TRUE(write_png(left, wall(0)));
    EXPECT_TRUE(write_png(right, wall(20)));
  }

  // The pair as a block with a point in every corner of the wall.
  static Block block() {
    Block block;
    block.cameras[CameraId{0}] = ideal_camera(kFocal_px, kWidth, kHeight);
    block.images[ImageId{0}] = {.file = "left.png", .camera = CameraId{0}};
    block.images[ImageId{1}] = {.file = "right.png", .camera = CameraId{0}};
    set_pose(block, ImageId{0}, {});
    set_pose(block, ImageId{1}, {Eigen::Quaterniond::Identity(), {-kBase_m, 0, 0}});
    std::uint32_t n = 0;
    for (const double x : {-1.5, -0.5, 0.5, 1.5})
      for (const double y : {-1.0, 0.0, 1.0}) {
        const PointId id{n++};
        block.points[id].position_in_world = {x, y, kDepth_m};
        for (std::uint32_t i = 0; i < 2; ++i)
          block.observations.push_back(
              {ImageId{i}, id, n,
               *project(block.cameras.at(CameraId{0}), pose_of(block, ImageId{i}) * Eigen::Vector3d(x, y, 5)), 1});
      }
    return block;
  }
};

void expect_the_wall(const std::filesystem::path& cloud_file) {
  const auto cloud = read_ply(cloud_file);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_GT(cloud->size(), 25'000u);
  std::size_t near = 0;
  for (const CloudPoint& point : *cloud) {
    near += std::abs(point.position.z() - kDepth_m) < 0.025;  // 0.1 px
    ASSERT_GT(point.sigma_m, 0);
    ASSERT_EQ(point.images, 2);
  }
  EXPECT_GT(near, 0.97 * double(cloud->size()));
}

TEST(StereoPair, RectifiedImagesGiveDisparitiesAndACloudWhereTheCamerasAreKnown) {
  const StereoImages photos;
  StereoPairOptions pair;
  pair.rectified = true;
  pair.max_disparity = 40;
  const auto plain = match_stereo(photos.left, photos.right, photos.folder / "plain", pair, {}, {});
  ASSERT_TRUE(plain) << plain.error().message;
  const auto disparity = read_float_tiff(photos.folder / "plain/disparity.tif");
  ASSERT_TRUE(disparity);
  EXPECT_NEAR(disparity->at(120, 80), 20, 0.1);
  EXPECT_FALSE(is_there(photos.folder / "plain/cloud.ply"));
  EXPECT_TRUE(is_there(photos.folder / "plain/disparity.png"));
  EXPECT_TRUE(is_there(photos.folder / "plain/stereo.json"));
  EXPECT_FALSE(plain->cameras);
  EXPECT_GT(plain->measured, plain->pixels / 2);
  pair.focal_px = kFocal_px;
  pair.base_m = kBase_m;
  ASSERT_TRUE(match_stereo(photos.left, photos.right, photos.folder / "cloud", pair, {}, {}));
  expect_the_wall(photos.folder / "cloud/cloud.ply");
  // Without cameras there is none, nor that of the run before.
  pair.focal_px.reset();
  pair.base_m.reset();
  ASSERT_TRUE(match_stereo(photos.left, photos.right, photos.folder / "cloud", pair, {}, {}));
  EXPECT_FALSE(is_there(photos.folder / "cloud/cloud.ply"));
}

double share_near_20(const std::filesystem::path& folder) {
  const auto disparity = read_float_tiff(folder / "disparity.tif");
  EXPECT_TRUE(disparity);
  if (!disparity) return 0;
  int near = 0;
  for (int y = 20; y < kHeight - 20; ++y)
    for (int x = 50; x < kWidth - 20; ++x) near += std::abs(disparity->at(x, y) - 20) < 0.3f;
  return double(near) / ((kHeight - 40) * (kWidth - 70));
}

TEST(StereoPair, EveryMatcherFindsTheWall) {
  const StereoImages photos;
  StereoPairOptions pair;
  pair.rectified = true;
  pair.max_disparity = 40;
  pair.focal_px = kFocal_px;
  pair.base_m = kBase_m;
  for (const auto& [matcher, word, meaning] : kStereoMatcherWords) {
    StereoMatching matching;
    matching.matcher = matcher;
    const auto out = photos.folder / std::string(word);
    const auto plain = match_stereo(photos.left, photos.right, out, pair, matching, {});
    ASSERT_TRUE(plain) << word << plain.error().message;
    EXPECT_EQ(plain->matcher, matcher);
    EXPECT_GT(plain->measured, 0u);
    EXPECT_TRUE(plain->median_sigma_px);
    EXPECT_EQ(plain->levels.empty(), matcher != StereoMatcher::kLevels);
    EXPECT_GT(plain->cameras->points, 0u);
    matching.dense.fill = true;
    const auto filled = match_stereo(photos.left, photos.right, out, pair, matching, {});
    ASSERT_TRUE(filled) << word << filled.error().message;
    EXPECT_EQ(filled->measured, plain->measured) << word;
    EXPECT_GT(share_near_20(out), 0.97) << word;
  }
}

TEST(StereoPair, RankAndCensusAloneMakeNoCloud) {
  const StereoImages photos;
  StereoPairOptions pair;
  pair.rectified = true;
  pair.max_disparity = 40;
  pair.focal_px = kFocal_px;
  pair.base_m = kBase_m;
  StereoMatching matching;
  matching.matcher = StereoMatcher::kLocal;
  matching.local.similarity = Similarity::kCensus;
  const auto done = match_stereo(photos.left, photos.right, photos.folder / "out", pair, matching, {});
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_GT(share_near_20(photos.folder / "out"), 0.97);
  EXPECT_FALSE(done->median_sigma_px);
  EXPECT_FALSE(is_there(photos.folder / "out/cloud.ply"));
}

TEST(StereoPair, OptionsOfAnotherMatcherAreRefused) {
  const StereoImages photos;
  StereoPairOptions pair;
  pair.rectified = true;
  const auto is_refused = [&](const StereoMatching& matching) {
    const auto done = match_stereo(photos.left, photos.right, photos.folder / "out", pair, matching, {});
    return !done && done.error().code == Errc::kBadInput;
  };
  EXPECT_TRUE(is_refused({.local = {.window_px = 11}}));
  EXPECT_TRUE(is_refused({.levels = {.grid_px = 4}}));
  EXPECT_TRUE(is_refused({.matcher = StereoMatcher::kLocal, .dense = {.cost = StereoCost::kRank}}));
  EXPECT_TRUE(is_refused({.matcher = StereoMatcher::kLevels, .dense = {.min_patch_px = 9}}));
  EXPECT_FALSE(is_refused({.matcher = StereoMatcher::kLocal, .dense = {.min_patch_px = 9}}));
}

TEST(StereoPair, ImagesOfAProjectAreFoundByName) {
  const StereoImages photos;
  Settings settings;
  settings.photos = (photos.folder / "photos").string();
  {
    auto project = create_project(photos.folder / "project", settings, {});
    ASSERT_TRUE(project) << project.error().message;
    ASSERT_TRUE(project->store.write_setup(StereoImages::block()));
    ASSERT_TRUE(project->store.write_orientation(StereoImages::block()));
  }
  StereoPairOptions pair;
  pair.project = (photos.folder / "project").string();
  const auto done = match_stereo("left.png", "right.png", photos.folder / "out", pair, {}, {});
  ASSERT_TRUE(done) << done.error().message;
  expect_the_wall(photos.folder / "out/cloud.ply");
  EXPECT_TRUE(is_there(photos.folder / "out/right.png"));
  for (const char* side : {"left.png", "right.png"}) {  // PNG: red, green, blue
    constexpr std::size_t kColourType = 25;
    const auto bytes = read_file(photos.folder / "out" / side);
    ASSERT_TRUE(bytes && bytes->size() > kColourType) << side;
    EXPECT_EQ((*bytes)[kColourType], 2) << side;
  }
}

TEST(StereoPair, AModelOfAnotherProgramWillDo) {
  const StereoImages photos;
  ASSERT_TRUE(write_colmap(photos.folder / "model", StereoImages::block(), ColmapEncoding::kText));
  StereoPairOptions pair;
  pair.orientation = (photos.folder / "model").string();
  const auto done = match_stereo(photos.left, photos.right, photos.folder / "out", pair, {}, {});
  ASSERT_TRUE(done) << done.error().message;
  expect_the_wall(photos.folder / "out/cloud.ply");
}

TEST(StereoPair, WhatIsMissingOrTooMuchIsStated) {
  const StereoImages photos;
  const auto out = photos.folder / "out";
  StereoPairOptions nothing, both, rectified, half;
  EXPECT_FALSE(match_stereo(photos.left, photos.right, out, nothing, {}, {}));
  both.rectified = true;
  both.project = "somewhere";
  EXPECT_FALSE(match_stereo(photos.left, photos.right, out, both, {}, {}));
  rectified.rectified = true;
  EXPECT_FALSE(match_stereo(photos.left, "nowhere.png", out, rectified, {}, {}));
  half.rectified = true;
  half.focal_px = 100;
  EXPECT_FALSE(match_stereo(photos.left, photos.right, out, half, {}, {}));
  Block without_points = StereoImages::block();
  without_points.points.clear();
  without_points.observations.clear();
  ASSERT_TRUE(write_colmap(photos.folder / "bare", without_points, ColmapEncoding::kText));
  StereoPairOptions bare;
  bare.orientation = (photos.folder / "bare").string();
  EXPECT_FALSE(match_stereo(photos.left, photos.right, out, bare, {}, {}));
  bare.min_disparity = 0;
  bare.max_disparity = 40;
  EXPECT_TRUE(match_stereo(photos.left, photos.right, out, bare, {}, {}));
}

}  // namespace
}  // namespace collinea
