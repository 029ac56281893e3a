// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/geometry/rotation.h"
#include "collinea/io/bingo.h"
#include "collinea/io/internal/test_damage.h"
#include "collinea/io/patb.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
constexpr double kPixel_um = 4.4;

// Three images of one distorted camera over six points and three of control, one of which is surveyed in height alone.
Block block_to_write() {
  Block block;
  Camera camera = ideal_camera(3000, 4000, 3000);
  camera.params[Camera::kCx] += 12;
  camera.params[Camera::kK1] = -0.06;
  camera.params[Camera::kP1] = 3e-4;
  camera.name = "FC6310";
  block.cameras[{2}] = camera;
  for (std::uint32_t i = 0; i < 3; ++i) {
    block.images[{i + 4}] = {.file = "DSC 0" + std::to_string(i) + ".jpg", .camera = {2}};
    const Eigen::Quaterniond rotation = cam_from_world(OmegaPhiKappa{2.0 * i - 1, 3 - 1.5 * i, 10 + 80.0 * i});
    set_pose(block, {i + 4}, {rotation, -(rotation * Eigen::Vector3d(12.0 * i, 3, 60))});
  }
  Random random(2);
  const auto measure = [&](const Eigen::Vector3d& position, auto&& add) {
    for (const auto& [image, pose] : oriented_images(block))
      if (const auto pixel = project(camera, pose * position); pixel && inside(camera, *pixel)) add(image, *pixel);
  };
  for (std::uint32_t i = 0; i < 6; ++i) {
    const Eigen::Vector3d position(random.uniform(0, 24), random.uniform(-8, 12), random.uniform(0, 4));
    block.points[{100 + i}] = {position, {}};
    measure(position, [&](ImageId image, const Eigen::Vector2d& pixel) {
      block.observations.push_back({image, {100 + i}, 0, pixel, 0.4});
    });
  }
  for (std::uint32_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d position(4 + 7.0 * i, 2.0 * i, 1.0 + i);
    block.control[{i}] = {.name = "GCP " + std::to_string(i),
                          .role = i == 1 ? ControlRole::kCheck : ControlRole::kControl,
                          .position_in_map = position,
                          .position_in_world = position,
                          .sigma_m = {0.01, 0.02, 0.03}};
    measure(position, [&](ImageId image, const Eigen::Vector2d& pixel) {
      block.control_observations.push_back({{i}, image, pixel, 0.4});
    });
  }
  return block;
}

ImageId image_called(const Block& block, const std::string& file) {
  for (const auto& [id, image] : block.images)
    if (image.file == file) return id;
  return {};
}

// The rays of the block and of what was read are the same: directions from the centre of the image.
void expect_same_rays(const Block& read, const Block& written) {
  ASSERT_EQ(read.images.size(), written.images.size());
  ASSERT_EQ(read.control_observations.size(), written.control_observations.size());
  ASSERT_EQ(read.observations.size(), written.observations.size());
  std::map<std::pair<std::string, std::string>, Eigen::Vector3d> rays;
  for (const ControlObservation& seen : written.control_observations)
    rays[{written.images.at(seen.image).file, written.control.at(seen.point).name}] =
        ray_in_cam(written.camera_of(seen.image), seen.pixel);
  for (const ControlObservation& seen : read.control_observations) {
    const auto its = rays.find({read.images.at(seen.image).file, read.control.at(seen.point).name});
    ASSERT_NE(its, rays.end());
    EXPECT_LT((ray_in_cam(read.camera_of(seen.image), seen.pixel) - its->second).norm(), 1e-7);
    EXPECT_NEAR(seen.sigma_px, 0.4, 1e-9);
  }
  for (const Observation& mine : read.observations) {
    const ImageId image = image_called(written, read.images.at(mine.image).file);
    const Eigen::Vector3d ray = ray_in_cam(read.camera_of(mine.image), mine.pixel);
    double nearest = 1;
    for (const Observation& its : written.observations)
      if (its.image == image)
        nearest = std::min(nearest, (ray - ray_in_cam(written.camera_of(image), its.pixel)).norm());
    EXPECT_LT(nearest, 1e-7);
  }
  EXPECT_TRUE(
      std::ranges::is_sorted(read.observations, {}, [](const Observation& o) { return std::pair(o.point, o.image); }));
}

TEST(Patb, WhatIsWrittenComesBackWithNamesAndSigmas) {
  const TestFolder folder;
  Block block = block_to_write();
  block.control.at({2}).sigma_m.head<2>().setConstant(std::numeric_limits<double>::infinity());
  ASSERT_TRUE(write_patb(folder / "block.im", block, kPixel_um));
  EXPECT_TRUE(is_patb(*read_file(folder / "block.im")));
  const auto file = read_patb(folder / "block.im");
  ASSERT_TRUE(file) << file.error().message;
  expect_same_rays(file->block, block);
  for (const auto& [id, point] : file->block.control) {
    const ControlPoint& given = block.control.at({std::uint32_t(point.name.back() - '0')});
    EXPECT_EQ(point.name, given.name);
    EXPECT_EQ(point.role, given.role);
    EXPECT_EQ(point.sigma_m, given.sigma_m);
    EXPECT_NEAR(point.position_in_world.z(), given.position_in_world.z(), 1e-4);
    if (std::isfinite(given.sigma_m.x())) EXPECT_LT((point.position_in_world - given.position_in_world).norm(), 1e-4);
  }
  const Camera& camera = file->block.cameras.begin()->second;
  EXPECT_NEAR(camera.focal_px(), 3000, 1e-4);
  EXPECT_EQ(camera.params[Camera::kK1], 0);
  EXPECT_FALSE(camera.prior.calibrate);
}

TEST(Patb, ForeignFilesAreReadWithoutNamesAndControl) {
  const TestFolder folder;
  const std::string text =
      "      1001  153119.000\n"
      "        11   12345.6  -23456.7   1\n"
      "        12   -2345.6   3456.7\n"
      "       -99\n"
      "      1002  153119.000\n"
      "        11   1.0D+0  2\n"
      "       -99\n"
      "       -99\n";
  const std::string good = std::string(text).replace(text.find("1.0D+0"), 6, "100.25");
  std::ofstream(folder / "a.im") << good;
  EXPECT_TRUE(is_patb(good));
  const auto file = read_patb(folder / "a.im");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->block.images.size(), 2u);
  EXPECT_EQ(file->block.cameras.size(), 1u);
  EXPECT_EQ(file->block.observations.size(), 3u);
  const Observation& seen = file->block.observations[0];
  const Camera& camera = file->block.camera_of(seen.image);
  const Eigen::Vector2d xy = normalized(camera, seen.pixel) * 153119;
  EXPECT_LT((xy - Eigen::Vector2d(12345.6, 23456.7)).norm(), 1e-6);
  EXPECT_EQ(seen.sigma_px, 3);
  std::ofstream(folder / "b.im") << text;
  const auto bad = read_patb(folder / "b.im");
  ASSERT_FALSE(bad);
  EXPECT_NE(bad.error().message.find("b.im: line 6: a measured point is expected"), std::string::npos)
      << bad.error().message;
}

struct Bad {
  const char *file, *text, *message;
};

TEST(Patb, WhatIsWrongIsNamedByFileAndLine) {
  const std::string image = "1 3000\n5 1 2\n6 3 4\n-99\n";
  for (const Bad& bad :
       {Bad{"a.im", "1 3000\n5 1\n-99\n", "a.im: line 2: a measured point"},
        Bad{"a.im", "1 3000\n5 1 2\n5 1 2\n-99\n", "a.im: line 3: point 5 is there twice in image 1"},
        Bad{"a.im", "1 3000\n5 1 2\n-99\n1 3000\n5 1 2\n-99\n", "a.im: line 4: image 1 is there twice"},
        Bad{"a.im", "1 -3000\n5 1 2\n-99\n", "a.im: line 1: the focal length of image 1"},
        Bad{"a.im", "1 3000\n5 nan 2\n-99\n", "a.im: line 2"}, Bad{"a.im", "1\n5 1 2\n-99\n", "a.im: line 1"},
        Bad{"a.im", "", "a.im: no image"}, Bad{"a.im", "1 3000\n-99\n", "a.im: no point is measured"},
        Bad{"a.con", "5 1\n-99\n-99\n", "a.con: line 1: horizontal control is expected"},
        Bad{"a.con", "5 1 x\n-99\n-99\n", "a.con: line 1: \"x\" is not a coordinate"},
        Bad{"a.con", "5 1 2\n5 1 2\n-99\n", "a.con: line 2: point 5 is there twice"},
        Bad{"a.con", "-99\n5\n", "a.con: line 2: vertical control"}, Bad{"a.con", "-99\n-99\n5 1 2\n", "a.con: line 3"},
        Bad{"a.names", "image 1\n", "a.names: line 1: expected: image NUMBER FILE"},
        Bad{"a.names", "unit 0\n", "a.names: line 1"}, Bad{"a.names", "colour 1\n", "a.names: line 1"},
        Bad{"a.names", "control 1 control 1 1 -1 A\n", "a.names: line 1: a standard deviation"}}) {
    const TestFolder folder;
    std::ofstream(folder / "a.im") << image;
    std::ofstream(folder / bad.file) << bad.text;
    const auto file = read_patb(folder / "a.im");
    ASSERT_FALSE(file) << bad.text;
    EXPECT_NE(file.error().message.find(bad.message), std::string::npos) << file.error().message;
  }
  const TestFolder folder;
  EXPECT_FALSE(read_patb(folder / "none.im"));
  Block fisheye = block_to_write();
  fisheye.cameras.at({2}).model = Equidistant{};
  const auto written = write_patb(folder / "f.im", fisheye, kPixel_um);
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("fisheye"), std::string::npos);
}

TEST(Bingo, WhatIsWrittenComesBackWithPosesNamesAndSigmas) {
  const TestFolder folder;
  const Block block = block_to_write();
  ASSERT_TRUE(write_bingo(folder / "image.dat", block, kPixel_um));
  EXPECT_TRUE(is_bingo(*read_file(folder / "image.dat"), true));
  const auto file = read_bingo(folder / "image.dat");
  ASSERT_TRUE(file) << file.error().message;
  expect_same_rays(file->block, block);
  ASSERT_EQ(count_oriented(file->block), 3u);
  for (const auto& [id, pose] : oriented_images(file->block)) {
    const Rigid3 truth = pose_of(block, image_called(block, file->block.images.at(id).file));
    EXPECT_LT((centre_of(pose) - centre_of(truth)).norm(), 1e-4);
    EXPECT_LT(angle_between(pose.rotation, truth.rotation), 1e-8);
  }
  int checks = 0;
  for (const auto& [id, point] : file->block.control) checks += point.role == ControlRole::kCheck;
  EXPECT_EQ(checks, 1);
}

// As Pix4D writes it: an empty line in place of -99, and one behind a head.
TEST(Bingo, EmptyLinesPartImagesToo) {
  const TestFolder folder;
  const std::string text =
      "P1060498 H_8.07\n1006 -1.90643 1.83493\n1020 2.00132 -0.797681\n\nP1060499 H_8.07\n\n1006 -2.42102 1.87814\n"
      "1020 2.15263 -0.33399\n";
  EXPECT_TRUE(is_bingo(text, false));
  EXPECT_FALSE(is_patb(text));
  std::ofstream(folder / "image.dat") << text;
  std::ofstream(folder / "geoin.dat")
      << "* a remark\nC another\nCAPA H_8.07 0 8.07 0.1 -0.2\nCONT 1020 1 2 3\nDIST 1\n";
  const auto file = read_bingo(folder / "image.dat");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->block.images.at({0}).file, "P1060498");
  EXPECT_EQ(file->block.observations.size(), 2u);
  EXPECT_EQ(file->block.control_observations.size(), 2u);
  const ControlObservation& seen = file->block.control_observations[0];
  const Eigen::Vector2d xy = normalized(file->block.camera_of(seen.image), seen.pixel) * 8.07;
  EXPECT_LT((xy - Eigen::Vector2d(2.00132 - 0.1, 0.797681 - 0.2)).norm(), 1e-9);
}

TEST(Bingo, WhatIsWrongIsNamedByFileAndLine) {
  const std::string image = "1 C1\n5 1 2\n6 3 4\n-99\n", geoin = "CAPA C1 0 20 0 0\nCONT 5 1 2 3\n";
  for (const Bad& bad :
       {Bad{"image.dat", "1 C2\n5 1 2\n-99\n", "image.dat: line 1: geoin.dat has no camera C2"},
        Bad{"image.dat", "1 C1\n5 1\n-99\n", "image.dat: line 2"},
        Bad{"geoin.dat", "CAPA C1 0 -20 0 0\n", "geoin.dat: line 1: expected: CAPA"},
        Bad{"geoin.dat", "CAPA C1 0 20\n", "geoin.dat: line 1"},
        Bad{"geoin.dat", "CAPA C1 0 20 0 0\nCONT 5 1 2\n", "geoin.dat: line 2: expected: CONT number E N H"},
        Bad{"geoin.dat", "CAPA C1 0 20 0 0\nCONT 5 1 2 3\nCHCK 5 1 2 3\n", "geoin.dat: line 3: point 5 is there twice"},
        Bad{"itera.dat", "ORIA 1 1 2 3 4 5\n", "itera.dat: line 1: expected: ORIA"},
        Bad{"names.dat", "what\n", "names.dat: line 1"}}) {
    const TestFolder folder;
    std::ofstream(folder / "image.dat") << image;
    std::ofstream(folder / "geoin.dat") << geoin;
    std::ofstream(folder / bad.file) << bad.text;
    const auto file = read_bingo(folder / "image.dat");
    ASSERT_FALSE(file) << bad.text;
    EXPECT_NE(file.error().message.find(bad.message), std::string::npos) << file.error().message;
  }
  const TestFolder folder;
  std::ofstream(folder / "image.dat") << image;
  const auto file = read_bingo(folder / "image.dat");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().message.find("geoin.dat"), std::string::npos);
}

TEST(PhotoFiles, DamageIsRefusedOrRead) {
  const TestFolder folder;
  const Block block = block_to_write();
  ASSERT_TRUE(write_patb(folder / "a.im", block, kPixel_um));
  ASSERT_TRUE(write_bingo(folder / "image.dat", block, kPixel_um));
  const auto damage = [&](const char* name, auto&& read) {
    const std::string text = *read_file(folder / name);
    read_damaged(
        text,
        [&](const std::string& broken) {
          std::ofstream(folder / name, std::ios::binary) << broken;
          static_cast<void>(is_patb(broken) || is_bingo(broken, true));
          static_cast<void>(read());
        },
        100, 37);
    std::ofstream(folder / name, std::ios::binary) << text;
  };
  for (const char* name : {"a.im", "a.con", "a.names"}) damage(name, [&] { return read_patb(folder / "a.im"); });
  for (const char* name : {"image.dat", "geoin.dat", "itera.dat", "names.dat"})
    damage(name, [&] { return read_bingo(folder / "image.dat"); });
}

}  // namespace
}  // namespace collinea
