// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>

#include "collinea/math/random.h"
#include "collinea/store/project_store.h"

// A store in a folder of its own, and blocks to be kept in it; for the tests of this module.
namespace collinea {

namespace fs = std::filesystem;

class ProjectStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() / ("collinea_store_" + std::string(info->name()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  ProjectStore open() {
    auto store = ProjectStore::open(folder_);
    EXPECT_TRUE(store) << (store ? "" : store.error().message);
    return std::move(*store);
  }
  fs::path folder_;
};

inline bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof(double)) == 0; }
template <class V>
inline bool same_vector(const V& a, const V& b) {
  for (Eigen::Index i = 0; i < a.size(); ++i)
    if (!same_bits(a[i], b[i])) return false;
  return true;
}

inline Eigen::Vector3d any_vector(Random& random) {
  return {random.normal(), random.normal() * 1e6, random.normal() * 1e-9};
}

inline Camera any_camera(Random& random, std::size_t model, std::size_t additional) {
  Camera camera = ideal_camera(1000 + random.normal(), 4000, 3000);
  camera.model = kCameraModels[model];
  camera.additional = AdditionalSet(additional);
  for (const int k : params_of(camera)) camera.params[std::size_t(k)] += random.normal();
  camera.name = "Maker Model \xc3\xa9";
  camera.prior.source = Provenance::kExif35mm;
  camera.prior.sigma_f_px = random.uniform();
  camera.prior.calibrate = false;
  if (camera.additional == AdditionalSet::kFilm)
    camera.prior.film = FilmPrior{random.normal(),
                                  500,
                                  0.02,
                                  true,
                                  model == 0,
                                  15,
                                  {{{1, random.normal()}, {0.1, 0.2}}, {{-3, 4}, {random.normal(), 0}}}};
  return camera;
}

inline ImagePair failed_pair(ImageId first, ImageId second) {
  ImagePair pair;
  pair.first = first;
  pair.second = second;
  return pair;
}

inline Block setup_block() {
  Random random(7);
  Block block;
  block.georeference = Georeference{"EPSG:32633", 41.1 + 1e-14, 16.9, -0.0};
  for (std::uint32_t i = 3; i < 3 + kCameraModels.size() * kAdditionalNames.size(); ++i)
    block.cameras[{i}] = any_camera(random, (i - 3) % kCameraModels.size(), (i - 3) / kCameraModels.size());
  for (std::uint32_t i = 0; i < 4; ++i) {
    Image image;
    image.file = "photo " + std::to_string(i) + ".jpg";
    image.camera = {3};
    image.taken = "2024:01:01 10:00:00.5";
    if (i % 2 == 0) image.position = PositionPrior{any_vector(random), any_vector(random), 41.123456789012345, 16, 100};
    if (i == 1) image.attitude = AttitudePrior{180, -90, 0.1};
    if (i == 2) image.attitude = AttitudePrior{12, -35, 0, {0.01, 0.02, 0.05}};
    image.orientation = 6;
    block.images[{i}] = image;
  }
  ControlPoint point{"GCP 1", ControlRole::kCheck, any_vector(random), any_vector(random), {0.02, 0.02, 0.03}};
  point.sigma_m.z() = std::numeric_limits<double>::infinity();
  block.control[{9}] = point;
  point.correlation = {0.5, -0.25, 1.0 / 3};
  block.control[{11}] = point;
  block.control[{2}] = {"S", ControlRole::kCheck, any_vector(random), any_vector(random), {0.02, 0.02, 0.03}};
  block.control_observations.push_back({{9}, {1}, {1.0 / 3, 2.0 / 3}, 0.5});
  block.control_observations.push_back({{11}, {1}, {1.0 / 3, 2.0 / 3}, 0.5, {1.7F, -0.3F}});
  block.geodetic.push_back(
      {GeodeticKind::kZenithAngle, "to the tower", {9}, {2}, 1.0 / 3, 1e-5, ControlRole::kCheck, 7, 1.6, 0.1});
  block.geodetic.push_back(
      {.kind = GeodeticKind::kOnLine, .name = "kerb", .from = {9}, .to = {9}, .sigma = 0.01, .setup = 0, .axis = 1});
  GeodeticObservation vector{
      .kind = GeodeticKind::kGnssVector, .from = {9}, .to = {2}, .sigma = 0.01, .setup = 3, .axis = 2};
  vector.along = {0.48, 0.6, 0.64};
  vector.is_local = true;
  block.geodetic.push_back(vector);
  return block;
}

inline Block oriented_block(std::uint32_t points) {
  Random random(8);
  Block block = setup_block();
  block.cameras[{3}].params[Camera::kK1] = -0.1234567890123;
  for (std::uint32_t i = 0; i < 4; ++i) set_pose(block, {i}, {Eigen::Quaterniond::UnitRandom(), any_vector(random)});
  for (std::uint32_t p = 0; p < points; ++p) {
    block.points[{2 * p}] = {any_vector(random), {std::uint8_t(p), 2, 255}};
    for (std::uint32_t i = 0; i < 4; ++i)
      block.observations.push_back({{i}, {2 * p}, p + i, {random.uniform(), random.uniform()}, random.uniform()});
  }
  block.control_observations[0].sigma_px = 0.25;
  return block;
}

inline void expect_same_cameras(const Block& a, const Block& b) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (const auto& [id, camera] : a.cameras) {
    const Camera& other = b.cameras.at(id);
    EXPECT_EQ(name_of(camera.model), name_of(other.model));
    EXPECT_EQ(camera.additional, other.additional);
    for (std::size_t i = 0; i < camera.params.size(); ++i) EXPECT_TRUE(same_bits(camera.params[i], other.params[i]));
    EXPECT_TRUE(same_bits(camera.prior.sigma_f_px, other.prior.sigma_f_px));
    EXPECT_EQ(camera.name, other.name);
    EXPECT_EQ(camera.prior.source, other.prior.source);
    EXPECT_EQ(camera.width_px, other.width_px);
    EXPECT_EQ(camera.height_px, other.height_px);
    EXPECT_EQ(camera.prior.calibrate, other.prior.calibrate);
    EXPECT_EQ(camera.prior.film, other.prior.film);
  }
}

inline void expect_same_images(const Block& a, const Block& b) {
  ASSERT_EQ(a.images.size(), b.images.size());
  for (const auto& [id, image] : a.images) {
    const Image& other = b.images.at(id);
    EXPECT_EQ(image.file, other.file);
    EXPECT_EQ(image.camera, other.camera);
    EXPECT_EQ(image.taken, other.taken);
    EXPECT_EQ(image.orientation, other.orientation);
    ASSERT_EQ(image.position.has_value(), other.position.has_value());
    ASSERT_EQ(image.attitude.has_value(), other.attitude.has_value());
    if (image.position) {
      EXPECT_TRUE(same_vector(image.position->position_in_world, other.position->position_in_world));
      EXPECT_TRUE(same_vector(image.position->sigma_m, other.position->sigma_m));
      EXPECT_TRUE(same_bits(image.position->latitude_deg, other.position->latitude_deg));
      EXPECT_EQ(image.position->longitude_deg, other.position->longitude_deg);
      EXPECT_EQ(image.position->height_m, other.position->height_m);
    }
    if (image.attitude) {
      EXPECT_EQ(image.attitude->heading_deg, other.attitude->heading_deg);
      EXPECT_EQ(image.attitude->pitch_deg, other.attitude->pitch_deg);
      EXPECT_TRUE(same_bits(image.attitude->roll_deg, other.attitude->roll_deg));
      EXPECT_EQ(image.attitude->sigma_deg, other.attitude->sigma_deg);
    }
  }
}

inline void expect_same_control(const Block& a, const Block& b) {
  ASSERT_EQ(a.control.size(), b.control.size());
  for (const auto& [id, point] : a.control) {
    const ControlPoint& other = b.control.at(id);
    EXPECT_EQ(point.name, other.name);
    EXPECT_EQ(point.role, other.role);
    EXPECT_TRUE(same_vector(point.position_in_map, other.position_in_map));
    EXPECT_TRUE(same_vector(point.position_in_world, other.position_in_world));
    EXPECT_TRUE(same_vector(point.sigma_m, other.sigma_m));
    EXPECT_TRUE(same_vector(point.correlation, other.correlation));
  }
  ASSERT_EQ(a.geodetic.size(), b.geodetic.size());
  for (std::size_t i = 0; i < a.geodetic.size(); ++i) {
    const GeodeticObservation &one = a.geodetic[i], &other = b.geodetic[i];
    EXPECT_EQ(std::tie(one.kind, one.name, one.from, one.to, one.role, one.setup, one.axis),
              std::tie(other.kind, other.name, other.from, other.to, other.role, other.setup, other.axis));
    EXPECT_EQ(std::tie(one.value, one.sigma, one.instrument_height_m, one.target_height_m),
              std::tie(other.value, other.sigma, other.instrument_height_m, other.target_height_m));
    EXPECT_EQ(one.along, other.along);
    EXPECT_EQ(one.is_local, other.is_local);
  }
  ASSERT_EQ(a.control_observations.size(), b.control_observations.size());
  for (std::size_t i = 0; i < a.control_observations.size(); ++i) {
    EXPECT_EQ(a.control_observations[i].image, b.control_observations[i].image);
    EXPECT_EQ(a.control_observations[i].point, b.control_observations[i].point);
    EXPECT_TRUE(same_vector(a.control_observations[i].pixel, b.control_observations[i].pixel));
    EXPECT_TRUE(same_bits(a.control_observations[i].sigma_px, b.control_observations[i].sigma_px));
    EXPECT_EQ(a.control_observations[i].shape, b.control_observations[i].shape);
  }
}

inline void expect_same_orientation(const Block& a, const Block& b) {
  ASSERT_EQ(count_oriented(a), count_oriented(b));
  for (const auto& [id, pose] : oriented_images(a)) {
    EXPECT_TRUE(same_vector(pose.rotation.coeffs(), pose_of(b, id).rotation.coeffs()));
    EXPECT_TRUE(same_vector(pose.translation, pose_of(b, id).translation));
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  for (const auto& [id, point] : a.points) {
    EXPECT_TRUE(same_vector(point.position_in_world, b.points.at(id).position_in_world));
    EXPECT_EQ(point.colour, b.points.at(id).colour);
  }
  ASSERT_EQ(a.observations.size(), b.observations.size());
  for (std::size_t i = 0; i < a.observations.size(); ++i) {
    const Observation &x = a.observations[i], &y = b.observations[i];
    ASSERT_TRUE(x.image == y.image && x.point == y.point && x.feature == y.feature);
    ASSERT_TRUE(same_vector(x.pixel, y.pixel) && same_bits(x.sigma_px, y.sigma_px));
  }
}

}  // namespace collinea
