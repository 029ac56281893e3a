// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "collinea/base/file.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/io/bundler.h"
#include "collinea/io/colmap.h"
#include "collinea/io/internal/colmap_model.h"
#include "collinea/io/opk.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

class OrientationFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("collinea_orientation_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

Camera brown_camera() {
  Camera camera = ideal_camera(1000, 1200, 800);
  auto& p = camera.params;
  p[Camera::kCx] += 3;
  p[Camera::kK1] = -0.05;
  p[Camera::kK2] = 0.02;
  p[Camera::kK3] = -0.004;
  p[Camera::kP1] = 0.002;
  p[Camera::kP2] = -0.001;
  p[Camera::kB1] = 1.5;
  return camera;
}

// Nadir images 100 m above ground, with exact observations.
Block nadir_block() {
  Block block;
  block.cameras[{0}] = brown_camera();
  for (std::uint32_t i = 0; i < 3; ++i) {
    Image image;
    image.file = "flight 1/photo" + std::to_string(i) + ".jpg";
    image.camera = {0};
    block.images[{i}] = image;
    const Eigen::Quaterniond rotation = cam_from_world({1.0 + i, -2.0, 30.0 * i});
    const Eigen::Vector3d centre(20.0 * i, 5, 100);
    set_pose(block, {i}, {rotation, -(rotation * centre)});
  }
  Random random(6);
  for (std::uint32_t p = 0; p < 200; ++p) {
    const Eigen::Vector3d ground(random.uniform(-50, 90), random.uniform(-40, 50), random.uniform(0, 5));
    std::vector<Observation> seen;
    for (const auto& [id, pose] : oriented_images(block)) {
      const auto pixel = project(block.cameras[{0}], pose * ground);
      if (pixel && inside(block.cameras[{0}], *pixel)) {
        Observation o;
        o.image = id;
        o.point = {p};
        o.pixel = *pixel;
        seen.push_back(o);
      }
    }
    if (seen.size() < 2) continue;
    block.points[{p}] = {ground, {std::uint8_t(p), 7, 255}};
    block.observations.insert(block.observations.end(), seen.begin(), seen.end());
  }
  return block;
}

TEST_F(OrientationFiles, AColmapModelComesBackExactlyFromTextAndFromBinary) {
  const Block block = nadir_block();
  ASSERT_GT(block.points.size(), 50u);
  for (const auto encoding : {ColmapEncoding::kText, ColmapEncoding::kBinary}) {
    fs::remove_all(folder_);
    const auto findings = write_colmap(folder_, block, encoding);
    ASSERT_TRUE(findings) << findings.error().message;
    EXPECT_TRUE(findings->empty());
    const auto back = read_colmap(folder_);
    ASSERT_TRUE(back) << back.error().message;
    ASSERT_EQ(back->images.size(), 3u);
    for (const auto& [id, image] : block.images) {
      EXPECT_EQ(back->images.at(id).file, image.file);
      EXPECT_EQ(pose_of(*back, id).rotation.coeffs(), pose_of(block, id).rotation.coeffs());
      EXPECT_EQ(pose_of(*back, id).translation, pose_of(block, id).translation);
    }
    for (int i = 0; i < Camera::kParams; ++i)
      EXPECT_EQ(back->cameras.at({0}).params[i], block.cameras.at({0}).params[i]) << Camera::kParamNames[i];
    ASSERT_EQ(back->points.size(), block.points.size());
    for (const auto& [id, point] : block.points) {
      EXPECT_EQ(back->points.at(id).position_in_world, point.position_in_world);
      EXPECT_EQ(back->points.at(id).colour, point.colour);
    }
    ASSERT_EQ(back->observations.size(), block.observations.size());
    for (std::size_t i = 0; i < block.observations.size(); ++i) {
      EXPECT_EQ(back->observations[i].point, block.observations[i].point);
      EXPECT_EQ(back->observations[i].image, block.observations[i].image);
      EXPECT_EQ(back->observations[i].pixel, block.observations[i].pixel);
    }
  }
}

// COLMAP's FULL_OPENCV as its own documentation and OpenCV's give it, against our camera.
TEST_F(OrientationFiles, FullOpencvParametersProjectToTheSamePixels) {
  const Block block = nadir_block();
  ASSERT_TRUE(write_colmap(folder_, block, ColmapEncoding::kText));
  const auto cameras = colmap::parse_cameras_text(*read_file(folder_ / "cameras.txt"));
  ASSERT_TRUE(cameras);
  const auto& v = cameras->at(0).params;
  ASSERT_EQ(v.size(), 12u);
  for (const double x : {-0.5, 0.1, 0.45})
    for (const double y : {-0.3, 0.05, 0.35}) {
      const double r2 = x * x + y * y, radial = 1 + r2 * (v[4] + r2 * (v[5] + r2 * v[8]));
      const double u = x * radial + 2 * v[6] * x * y + v[7] * (r2 + 2 * x * x);
      const double w = y * radial + 2 * v[7] * x * y + v[6] * (r2 + 2 * y * y);
      const Eigen::Vector2d theirs(v[0] * u + v[2], v[1] * w + v[3]);
      EXPECT_LT((*project(block.cameras.at({0}), {x, y, 1}) - theirs).norm(), 1e-10);
    }
}

TEST_F(OrientationFiles, PointsCarryTheirMeanResidual) {
  Block block = nadir_block();
  const PointId point = block.observations[0].point;
  double count = 0;
  for (const Observation& o : block.observations) count += o.point == point;
  block.observations[0].pixel += Eigen::Vector2d(3, 4);
  ASSERT_TRUE(write_colmap(folder_, block, ColmapEncoding::kBinary));
  const auto points = colmap::parse_points_binary(*read_file(folder_ / "points3D.bin"));
  ASSERT_TRUE(points);
  EXPECT_EQ(points->at(0).id, point.value + 1);
  EXPECT_NEAR(points->at(0).error_px, 5 / count, 1e-9);
}

TEST_F(OrientationFiles, WhatColmapCannotHoldIsStated) {
  Block block = nadir_block();
  block.cameras[{0}].params[Camera::kB2] = 0.5;
  remove_pose(block, {2});
  const auto findings = write_colmap(folder_, block, ColmapEncoding::kText);
  ASSERT_TRUE(findings);
  ASSERT_EQ(findings->size(), 2u);
  EXPECT_EQ(findings->at(0).code, FindingCode::kShearDropped);
  EXPECT_NEAR(findings->at(0).figure(FigureName::kOffsetPx).value_or(0), 0.2, 5e-4);  // 0.5 / 1000 * 400
}

// Whatever the fisheye, COLMAP's camera sees the points where ours does.
TEST_F(OrientationFiles, FisheyesComeBackFromColmap) {
  for (const CameraModel model : {CameraModel(Equidistant{}), CameraModel(Equisolid{}), CameraModel(KannalaBrandt{})}) {
    Block block = nadir_block();
    Camera& camera = block.cameras.begin()->second;
    camera.model = model;
    camera.params[Camera::kF] = 0.5 * camera.width_px;
    camera.params[Camera::kB2] = 0;
    if (is<KannalaBrandt>(model)) {
      camera.params[Camera::kP1] = camera.params[Camera::kP2] = 0;
      camera.params[Camera::kK4] = 0.003;
    }
    fs::remove_all(folder_);
    const auto findings = write_colmap(folder_, block, ColmapEncoding::kText);
    ASSERT_TRUE(findings) << findings.error().message;
    EXPECT_EQ(findings->size(), is<Equisolid>(model) ? 1u : 0u);
    const auto back = read_colmap(folder_);
    ASSERT_EQ(bool(back), !is<Equisolid>(model));  // fitted, it has k4 beside p1 and p2
    if (!back) continue;
    const Camera& other = back->cameras.begin()->second;
    EXPECT_EQ(other.model, model);
    EXPECT_EQ(other.params, camera.params);
  }
}

TEST_F(OrientationFiles, BundlerKnowsNoFisheye) {
  Block block = nadir_block();
  block.cameras.begin()->second.model = Equidistant{};
  EXPECT_EQ(write_bundler(folder_, block).error().code, Errc::kUnsupported);
}

TEST_F(OrientationFiles, ColmapGetsImageCoordinatesFreedFromAdditionalParameters) {
  Block block = nadir_block();
  Camera& camera = block.cameras.begin()->second;
  camera.params[Camera::kB2] = 0;
  const Camera plain = camera;
  camera.additional = AdditionalSet::kEbner;
  camera.params[Camera::kParams + 5] = 2;
  for (Observation& o : block.observations)
    o.pixel = *project(camera, pose_of(block, o.image) * block.points.at(o.point).position_in_world);
  const auto findings = write_colmap(folder_, block, ColmapEncoding::kText);
  ASSERT_TRUE(findings);
  ASSERT_EQ(findings->size(), 1u);
  EXPECT_EQ(findings->at(0).code, FindingCode::kAdditionalDropped);
  EXPECT_NE(findings->at(0).detail.find("ebner"), std::string::npos);
  const auto back = read_colmap(folder_);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->cameras.begin()->second.params, plain.params);
  for (std::size_t i = 0; i < block.observations.size(); ++i) {
    const Observation& o = back->observations[i];
    EXPECT_LT((*project(plain, pose_of(*back, o.image) * back->points.at(o.point).position_in_world) - o.pixel).norm(),
              1e-6);
  }
}

TEST(Colmap, OtherCameraModelsAreTakenOrRefused) {
  const auto f = [](const std::string& row) { return colmap::parse_cameras_text(row); };
  EXPECT_EQ(f("1 SIMPLE_RADIAL 100 80 90 50 40 0.1\n")->at(0).params.back(), 0.1);
  EXPECT_FALSE(f("1 SIMPLE_RADIAL 100 80 90 50 40\n"));
  EXPECT_FALSE(f("1 NEW_MODEL 100 80 90 50 40 0.1\n"));
}

TEST_F(OrientationFiles, AModelWithoutPointsHasPosesOnly) {
  fs::create_directories(folder_);
  std::ofstream(folder_ / "cameras.txt") << "# c\n7 PINHOLE 100 80 90 91 50 40\n";
  std::ofstream(folder_ / "images.txt") << "# c\n0 1 0 0 0 1 2 3 7 my photo.jpg\n\n5 2 0 0 0 1 2 3 7 b.jpg\n";
  const auto block = read_colmap(folder_);
  ASSERT_TRUE(block) << block.error().message;
  EXPECT_EQ(block->images.at({0}).file, "my photo.jpg");
  EXPECT_EQ(block->images.at({5}).camera, CameraId{6});
  EXPECT_EQ(pose_of(*block, {5}).rotation.w(), 1);
  EXPECT_EQ(block->cameras.at({6}).params[Camera::kB1], -1);
  for (const char* unknown :
       {"7 FOV 100 80 90 91 50 40 0.5\n", "7 THIN_PRISM_FISHEYE 100 80 90 91 50 40 0 0 1 0 0 2 0 0\n",
        "7 THIN_PRISM_FISHEYE 100 80 90 91 50 40 0 0 0 0 0 0 1 0\n"}) {
    std::ofstream(folder_ / "cameras.txt") << unknown;
    EXPECT_EQ(read_colmap(folder_).error().code, Errc::kUnsupported) << unknown;
  }
}

TEST_F(OrientationFiles, NoBytesCrashTheColmapReaders) {
  const Block block = nadir_block();
  for (const auto encoding : {ColmapEncoding::kText, ColmapEncoding::kBinary}) {
    const std::string end = encoding == ColmapEncoding::kText ? ".txt" : ".bin";
    fs::remove_all(folder_);
    ASSERT_TRUE(write_colmap(folder_, block, encoding));
    int refused = 0;
    for (std::uint64_t trial = 0; trial < 60; ++trial) {
      Random random(12, trial);
      const auto path = folder_ / (std::array{"cameras", "images", "points3D"}[trial % 3] + end);
      const std::string whole = *read_file(path);
      std::string bytes = whole;
      for (int i = 0; i < 4; ++i) bytes[random.below(std::uint32_t(bytes.size()))] = char(random.bits());
      if (trial % 2) bytes.resize(random.below(std::uint32_t(bytes.size())));
      ASSERT_TRUE(write_file(path, bytes));
      refused += !read_colmap(folder_);
      ASSERT_TRUE(write_file(path, whole));
    }
    EXPECT_GT(refused, 15) << end;
  }
}

TEST(Opk, WithoutGeoreferenceItIsTheWorldFrame) {
  const auto rows = exterior_orientations(nadir_block());
  ASSERT_TRUE(rows);
  ASSERT_EQ(rows->size(), 3u);
  EXPECT_LT((rows->at(2).centre_in_map - Eigen::Vector3d(40, 5, 100)).norm(), 1e-9);
  EXPECT_NEAR(rows->at(2).angles.omega_deg, 3, 1e-9);
  EXPECT_NEAR(rows->at(2).angles.phi_deg, -2, 1e-9);
  EXPECT_NEAR(rows->at(2).angles.kappa_deg, 60, 1e-9);
}

// A nadir image with x to the true east: its kappa in the map is the meridian convergence (east of the central
// meridian grid north lies clockwise of true north, so true east anticlockwise of grid east), which is
// atan(tan(dlon) sin(lat)) for the transverse Mercator on the sphere; the ellipsoid changes it by less than 0.001 deg.
TEST(Opk, AnglesReferToTheGridOfTheMap) {
  const double latitude = 45, longitude = 17.5, radians = std::numbers::pi / 180;
  Block block = nadir_block();
  block.georeference = Georeference{"EPSG:32633", latitude, longitude, 100};
  for (auto [id, pose] : oriented_images(block)) {
    pose.rotation = cam_from_world(OmegaPhiKappa{});
    pose.translation = Eigen::Vector3d(0, 0, 0);
    set_pose(block, id, pose);
  }
  const auto rows = exterior_orientations(block);
  ASSERT_TRUE(rows) << rows.error().message;
  const double convergence = std::atan(std::tan(2.5 * radians) * std::sin(latitude * radians)) / radians;
  EXPECT_NEAR(rows->at(0).angles.kappa_deg, convergence, 1e-3);
  EXPECT_NEAR(rows->at(0).angles.omega_deg, 0, 1e-5);
  EXPECT_NEAR(rows->at(0).angles.phi_deg, 0, 1e-5);
  EXPECT_NEAR(rows->at(0).centre_in_map.z(), 100, 1e-6);
}

TEST_F(OrientationFiles, TheOpkTableIsReadable) {
  ASSERT_TRUE(write_opk(folder_ / "opk.txt", nadir_block()));
  const std::string text = *read_file(folder_ / "opk.txt");
  EXPECT_NE(text.find("flight 1/photo2.jpg\t40.0000\t5.0000\t100.0000\t3.0000000\t-2.0000000\t60.0000000\n"),
            std::string::npos)
      << text;
}

TEST_F(OrientationFiles, AnOpkTableComesBackAsPosesInTheWorldFrame) {
  Block block = nadir_block();
  for (const bool on_earth : {false, true}) {
    if (on_earth) block.georeference = Georeference{"EPSG:32633", 45, 17.5, 100};
    ASSERT_TRUE(write_opk(folder_ / "opk.txt", block));
    const auto rows = read_opk(folder_ / "opk.txt");
    ASSERT_TRUE(rows) << rows.error().message;
    const auto poses = poses_of(*rows, block);
    ASSERT_TRUE(poses) << poses.error().message;
    ASSERT_EQ(poses->size(), 3u);
    for (const auto& [id, pose] : oriented_images(block)) {  // written with 0.1 mm and 1e-7 degrees
      EXPECT_LT((centre_of(poses->at(id)) - centre_of(pose)).norm(), 1.5e-4);
      EXPECT_LT(angle_between(poses->at(id).rotation, pose.rotation), 1e-8);
    }
  }
}

TEST_F(OrientationFiles, WhatIsWrongInAnOpkTableIsNamedByItsLine) {
  const auto error_of = [&](const std::string& text) {
    EXPECT_TRUE(write_file(folder_ / "opk.txt", text));
    const auto rows = read_opk(folder_ / "opk.txt");
    return rows ? std::string("none") : rows.error().message;
  };
  EXPECT_EQ(error_of("# c\nmy photo.jpg 1 2 3 4 5 6\r\nb.jpg\t1\t2\t3\t4\t5\t6\n"), "none");
  EXPECT_EQ(read_opk(folder_ / "opk.txt")->at(0).file, "my photo.jpg");
  EXPECT_NE(error_of("a.jpg 1 2 3 4 5 6\n\nb.jpg 1 2 3 4 5\n").find("line 3"), std::string::npos);
  EXPECT_NE(error_of("a.jpg 1 2 3 4 5 nan\n").find("line 1"), std::string::npos);
  EXPECT_NE(error_of("a.jpg 1 2 3 4 5 6\na.jpg 1 2 3 4 5 6\n").find("line 2"), std::string::npos);
  EXPECT_NE(error_of("# nothing\n"), "none");
  EXPECT_EQ(read_opk(folder_ / "missing.txt").error().code, Errc::kNotFound);
}

// Bundler's documentation, in its own words: P = R X + t, p = -P / P.z, p' = f r(p) p, from the middle, y up.
TEST_F(OrientationFiles, BundlerFilesMeanWhatBundlerMeans) {
  const Block block = nadir_block();
  const auto findings = write_bundler(folder_, block);
  ASSERT_TRUE(findings) << findings.error().message;
  EXPECT_EQ(findings->size(), 1u);  // principal point and tangential terms were taken into the observations
  std::ifstream file(folder_ / "bundle.out");
  std::string line;
  std::getline(file, line);
  EXPECT_EQ(line, "# Bundle file v0.3");
  std::size_t cameras = 0, points = 0;
  file >> cameras >> points;
  ASSERT_EQ(cameras, 3u);
  EXPECT_EQ(points, block.points.size());
  std::vector<std::array<double, 15>> camera(cameras);
  for (auto& values : camera)
    for (double& value : values) file >> value;
  int looked_at = 0;
  for (std::size_t i = 0; i < points; ++i) {
    Eigen::Vector3d X;
    int red = 0, green = 0, blue = 0;
    std::size_t views = 0;
    file >> X[0] >> X[1] >> X[2] >> red >> green >> blue >> views;
    for (std::size_t v = 0; v < views; ++v) {
      std::size_t c = 0, key = 0;
      Eigen::Vector2d seen;
      file >> c >> key >> seen[0] >> seen[1];
      const auto& w = camera.at(c);
      const Eigen::Vector3d P = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&w[3]) * X +
                                Eigen::Vector3d(w[12], w[13], w[14]);
      EXPECT_LT(P.z(), 0);
      const Eigen::Vector2d p = -P.head<2>() / P.z();
      const double r2 = p.squaredNorm();
      EXPECT_LT((w[0] * (1 + w[1] * r2 + w[2] * r2 * r2) * p - seen).norm(), 1e-9);
      ++looked_at;
    }
  }
  EXPECT_TRUE(file);
  EXPECT_EQ(std::size_t(looked_at), block.observations.size());
}

TEST_F(OrientationFiles, ABundlerModelComesBackExactly) {
  Block block = nadir_block();
  auto& p = block.cameras[{0}].params;
  for (const int param : {Camera::kK3, Camera::kP1, Camera::kP2, Camera::kB1}) p[param] = 0;
  p[Camera::kCx] = 600;
  const auto findings = write_bundler(folder_, block);
  ASSERT_TRUE(findings);
  EXPECT_TRUE(findings->empty());
  const auto back = read_bundler(folder_, [](const std::string&) { return ImageSize{1200, 800}; });
  ASSERT_TRUE(back) << back.error().message;
  ASSERT_EQ(back->images.size(), 3u);
  for (const auto& [id, pose] : oriented_images(block)) {
    EXPECT_EQ(back->images.at(id).file, block.images.at(id).file);
    EXPECT_EQ(back->camera_of(id).params, block.camera_of(id).params);
    EXPECT_LT((pose_of(*back, id).translation - pose.translation).norm(), 1e-12);
    EXPECT_LT(angle_between(pose_of(*back, id).rotation, pose.rotation), 1e-7);
  }
  ASSERT_EQ(back->points.size(), block.points.size());
  ASSERT_EQ(back->observations.size(), block.observations.size());
  std::vector<Eigen::Vector3d> ours, theirs;
  for (const auto& [id, point] : block.points) ours.push_back(point.position_in_world);
  for (const auto& [id, point] : back->points) theirs.push_back(point.position_in_world);
  EXPECT_EQ(ours, theirs);
  for (std::size_t i = 0; i < block.observations.size(); ++i) {
    EXPECT_EQ(back->observations[i].image, block.observations[i].image);
    EXPECT_LT((back->observations[i].pixel - block.observations[i].pixel).norm(), 1e-9);
  }
}

TEST_F(OrientationFiles, WhatIsWrongInABundlerFileIsNamedByItsLine) {
  fs::create_directories(folder_);
  const auto size_of = [](const std::string&) { return ImageSize{100, 80}; };
  const std::string good = "90 0 0\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n";
  const auto error_of = [&](const std::string& text) {
    EXPECT_TRUE(write_file(folder_ / "list.txt", "my photo.jpg 0 90.5\n"));
    EXPECT_TRUE(write_file(folder_ / "bundle.out", text));
    const auto block = read_bundler(folder_, size_of);
    return block ? "none: " + block->images.at({0}).file : block.error().message;
  };
  EXPECT_EQ(error_of("# Bundle file v0.3\n1 0\n" + good), "none: my photo.jpg");
  EXPECT_EQ(error_of("# Bundle file v0.3\n1 0\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n"), "none: my photo.jpg");
  EXPECT_NE(error_of("# Bundle file v0.3\n2 0\n" + good).find("list.txt"), std::string::npos);
  EXPECT_NE(error_of("# Bundle file v0.3\n1 0\n90 0 0\n1 0 x\n").find("line 4"), std::string::npos);
  EXPECT_NE(error_of("# Bundle file v0.3\n1 0\n90 0 0\n1 0 1\n0 1 0\n0 0 1\n0 0 0\n").find("rotation"),
            std::string::npos);
  EXPECT_NE(error_of("# Bundle file v0.3\n1 1\n" + good + "1 2 3\n1 2 3\n1 4 0 0 0\n").find("line 10"),
            std::string::npos);
  EXPECT_NE(error_of("# Bundle file v0.3\n1 1000\n" + good).find("ends"), std::string::npos);
}

TEST_F(OrientationFiles, NoBytesCrashTheBundlerAndOpkReaders) {
  const Block block = nadir_block();
  ASSERT_TRUE(write_bundler(folder_, block));
  ASSERT_TRUE(write_opk(folder_ / "opk.txt", block));
  int refused = 0;
  for (std::uint64_t trial = 0; trial < 90; ++trial) {
    Random random(13, trial);
    const auto path = folder_ / std::array{"bundle.out", "list.txt", "opk.txt"}[trial % 3];
    const std::string whole = *read_file(path);
    std::string bytes = whole;
    for (int i = 0; i < 4; ++i) bytes[random.below(std::uint32_t(bytes.size()))] = char(random.bits());
    if (trial % 2) bytes.resize(random.below(std::uint32_t(bytes.size())));
    ASSERT_TRUE(write_file(path, bytes));
    refused += trial % 3 == 2 ? !read_opk(path) : !read_bundler(folder_, [](const std::string&) {
      return ImageSize{1200, 800};
    });
    ASSERT_TRUE(write_file(path, whole));
  }
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace collinea
