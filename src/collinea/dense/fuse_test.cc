// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/fuse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/dense/internal/test_scene.h"

namespace collinea {
namespace {

using test::Scene;

class MemoryStore : public DepthStore {
 public:
  Result<> write(ImageId image, const DepthMap& map) override {
    maps[image] = map;
    return {};
  }
  Result<DepthMap> read(ImageId image) override {
    if (!maps.count(image)) return fail(Errc::kNotFound, "no such map");
    return maps.at(image);
  }
  bool has(ImageId image) const override { return maps.count(image) > 0; }
  std::map<ImageId, DepthMap> maps;
};

// The true depth maps of a scene, with normally distributed errors of `sigma`.
MemoryStore true_maps(const Scene& scene, float sigma, double noise_in_sigmas) {
  MemoryStore store;
  for (const auto& [id, pose] : oriented_images(scene.block)) {
    const Camera& camera = scene.block.camera_of(id);
    DepthMap map{camera, FloatImage(camera.width_px, camera.height_px),
                 FloatImage(camera.width_px, camera.height_px, 1, sigma)};
    Random random(3, id.value);
    for (int y = 0; y < map.depth.height; ++y)
      for (int x = 0; x < map.depth.width; ++x)
        map.depth.at(x, y) = float(scene.truth(id, camera, x, y).depth + sigma * noise_in_sigmas * random.normal());
    store.maps[id] = std::move(map);
  }
  return store;
}

struct Cloud {
  std::vector<FusedPoint> points;
  FuseReport report;
  std::vector<std::string> log;
};

Cloud fused(const Scene& scene, MemoryStore& store, const DenseOptions& options = {}, int threads = 1,
            const ColourSource& colours = {}) {
  std::vector<ImageId> images;
  for (const auto& [id, map] : store.maps) images.push_back(id);
  Cloud cloud;
  collinea::Run run;
  run.threads = threads;
  run.log = [&](std::string_view line) { cloud.log.emplace_back(line); };
  const TieView ties(scene.block);
  auto report = fuse(
      scene.block, ties, images, store, colours,
      [&](std::span<const FusedPoint> points) -> Result<> {
        cloud.points.insert(cloud.points.end(), points.begin(), points.end());
        return {};
      },
      options, run);
  EXPECT_TRUE(report) << (report ? "" : report.error().message);
  if (report) cloud.report = *report;
  return cloud;
}

double height_above_ground(const Scene& scene, const FusedPoint& p) {
  return p.position_in_world.z() - scene.slope * p.position_in_world.x();
}

TEST(Fuse, ExactMapsGiveExactPointsAndNormals) {
  const Scene scene = Scene::of_four({.slope = 0.2});
  MemoryStore store = true_maps(scene, 0.01f, 0);
  const Cloud cloud = fused(scene, store);
  ASSERT_GT(cloud.points.size(), 10000u);
  EXPECT_EQ(cloud.report.points, std::int64_t(cloud.points.size()));
  const Eigen::Vector3f up = Eigen::Vector3f(-0.2f, 0, 1).normalized();
  for (const FusedPoint& p : cloud.points) {
    EXPECT_NEAR(height_above_ground(scene, p), 0, 1e-4);  // depths are floats around 10 m, interpolated
    EXPECT_GT(p.normal_in_world.dot(up), 0.999f);
  }
}

TEST(Fuse, EachPositionIsWrittenHardlyMoreThanOnce) {
  const Scene scene = Scene::of_four({.slope = 0});
  MemoryStore store = true_maps(scene, 0.01f, 0);
  const Cloud cloud = fused(scene, store);
  // where all four look, a pixel is 5 cm x 5 cm: 400 points per square metre
  const auto within = [](const FusedPoint& p) {
    return std::abs(p.position_in_world.x()) < 2 && std::abs(p.position_in_world.y()) < 1.5;
  };
  const auto count = std::count_if(cloud.points.begin(), cloud.points.end(), within);
  EXPECT_GT(double(count), 0.95 * 4 * 3 * 400);
  EXPECT_LT(double(count), 1.4 * 4 * 3 * 400);
}

TEST(Fuse, AgreeingMapsAreMoreAccurateThanOne) {
  const Scene scene = Scene::of_four({.slope = 0});
  MemoryStore store = true_maps(scene, 0.05f, 1);
  const Cloud cloud = fused(scene, store);
  double sum = 0;
  for (const FusedPoint& p : cloud.points) sum += std::pow(height_above_ground(scene, p), 2);
  EXPECT_LT(std::sqrt(sum / double(cloud.points.size())), 0.8 * 0.05);
}

// The same images tell all of them: n maps err less than one, but more than n independent ones would.
TEST(Fuse, SigmasKnowThatMapsShareTheirImages) {
  constexpr float kSigma = 0.01f;
  const Scene scene = Scene::of_four({.slope = 0});
  MemoryStore store = true_maps(scene, kSigma, 0);
  std::set<int> seen;
  for (const FusedPoint& p : fused(scene, store).points) {
    const double n = p.images, expected = kSigma * std::sqrt(1 / n + 8 / (n * n));  // of a ray of length 1
    ASSERT_GT(p.sigma, 0.999 * expected) << n;
    ASSERT_LT(p.sigma, 1.3 * expected) << n;
    seen.insert(p.images);
  }
  EXPECT_EQ(seen, (std::set<int>{2, 3, 4}));
}

// Two maps know it to 1 cm; the other two, to 1 m, agree with everything and make nothing surer.
TEST(Fuse, MapsOfNextToNoWeightAddNoCertainty) {
  constexpr float kSigma = 0.01f;
  const Scene scene = Scene::of_four({.slope = 0});
  MemoryStore store = true_maps(scene, kSigma, 0);
  for (const ImageId image : {std::next(store.maps.begin(), 2)->first, std::next(store.maps.begin(), 3)->first})
    for (float& sigma : store.maps[image].sigma.data) sigma = 1;
  const double of_two = kSigma * std::sqrt(1 / 2.0 + 8 / 4.0);  // of a ray of length 1
  std::size_t by_four = 0;
  for (const FusedPoint& p : fused(scene, store).points) {
    if (p.images < 4 || p.sigma > 0.1f) continue;  // larger: what the coarse maps see beside the precise ones
    ASSERT_GT(p.sigma, 0.999 * of_two);
    ASSERT_LT(p.sigma, 1.3 * of_two);
    ++by_four;
  }
  EXPECT_GT(by_four, 5000u);
}

TEST(Fuse, WhatOneMapAloneSaysIsDropped) {
  const Scene scene = Scene::of_four({.slope = 0});
  MemoryStore store = true_maps(scene, 0.01f, 0);
  for (int y = 60; y < 80; ++y)
    for (int x = 80; x < 120; ++x) store.maps.at(ImageId{0}).depth.at(x, y) = 8;
  for (const FusedPoint& p : fused(scene, store).points) EXPECT_LT(std::abs(height_above_ground(scene, p)), 0.1);
}

// Two images in a row and a third one, `aside`, that has measured nothing.
Scene with_a_blind_third(double aside) {
  Scene scene = {.slope = 0};
  for (const double x : {0.0, 1.0, aside}) scene.add_camera(x, 0, 0, Scene::camera());
  scene.add_ties();
  return scene;
}

// How many points fall into columns `left` to `right` of the third image, of those that its rows 20 to 140 show.
double part_written(const Scene& scene, MemoryStore& store, double left, double right) {
  for (float& depth : store.maps.at(ImageId{2}).depth.data) depth = std::numeric_limits<float>::quiet_NaN();
  int count = 0;
  for (const FusedPoint& p : fused(scene, store).points) {
    const auto pixel =
        project(scene.block.camera_of(ImageId{2}), pose_of(scene.block, ImageId{2}) * p.position_in_world);
    count += pixel && pixel->x() > left && pixel->x() < right && pixel->y() > 20 && pixel->y() < 140;
  }
  return count / ((right - left) * 120);
}

TEST(Fuse, ABlindImageMustNotAgreeWhereItLooksFromFarAsideOrWithItsFrame) {
  const Scene near = with_a_blind_third(4), wide = with_a_blind_third(6);  // rays meet at 0.4 and 0.58 rad
  MemoryStore near_maps = true_maps(near, 0.01f, 0), wide_maps = true_maps(wide, 0.01f, 0);
  EXPECT_EQ(part_written(near, near_maps, 7, 60), 0);  // it looks, and does not agree
  EXPECT_GT(part_written(wide, wide_maps, 7, 60), 0.9);
  EXPECT_GT(part_written(near, near_maps, 0.5, 5.5), 0.9);  // windows do not fit into the frame of an image
}

// Two images 2 m apart: a metre of depth is 4 px. Depths of 0.3 m less interpolated ones of 0.2 m have a deviation of
// 0.36 m = 1.44 px; within 2 sigmas = 2.4 px lie 90 % of them, within the 1 px of max_reprojection_px 51 %, within its
// four sigmas all. A fifth of the image is not on the other.
TEST(Fuse, RoughSurfacesAgreeWithinTwoSigmas) {
  Scene scene = {.slope = 0};
  for (const double x : {0.0, 2.0}) scene.add_camera(x, 0, 0, Scene::camera());
  scene.add_ties();
  MemoryStore store = true_maps(scene, 0.3f, 1);
  const double confirmed = fused(scene, store).report.confirmed.at(ImageId{0});
  EXPECT_NEAR(confirmed, 0.8 * 0.9, 0.04);
}

// The same two images and the blind one far aside: what the two know to 0.02 px is written, what they know to 0.6 px
// needs everybody that has it on the image.
TEST(Fuse, CoarseDepthsNeedImagesFarAsideToo) {
  const Scene wide = with_a_blind_third(6);
  MemoryStore coarse = true_maps(wide, 0.3f, 0);
  EXPECT_EQ(part_written(wide, coarse, 7, 60), 0);
}

// Three maps say that something floats 2 m above the ground, to `sigma` each; the fourth sees the ground to 1 cm.
std::size_t floating_points(float sigma) {
  const Scene scene = Scene::of_four({.slope = 0});
  MemoryStore store = true_maps(scene, 0.01f, 0);
  for (auto& [id, map] : store.maps) {
    if (id == ImageId{3}) continue;
    const Eigen::Vector3d centre = centre_of(pose_of(scene.block, id));
    for (int y = 0; y < map.depth.height; ++y)
      for (int x = 0; x < map.depth.width; ++x) {
        const Eigen::Vector3d on_ground = scene.truth(id, map.camera, x, y).point_in_world;
        const double part = (centre.z() - 2) / centre.z();
        const Eigen::Vector3d above = centre + part * (on_ground - centre);
        if (std::hypot(above.x(), above.y()) > 0.5) continue;
        map.depth.at(x, y) *= float(part);
        map.sigma.at(x, y) = sigma;
      }
  }
  const Cloud cloud = fused(scene, store);
  return std::size_t(std::count_if(cloud.points.begin(), cloud.points.end(),
                                   [&](const FusedPoint& p) { return height_above_ground(scene, p) > 1; }));
}

TEST(Fuse, APreciseDepthBehindOutweighsCoarseOnesThatAgree) {
  EXPECT_GT(floating_points(0.01f), 200u);  // a disc of 314 pixels
  EXPECT_EQ(floating_points(0.2f), 0u);
}

// Noise of 2 px of the ground makes every normal wrong. What is averaged is within four sigmas of both depths from the
// pixel's own depth, so no point can be farther off than that and its own error, five sigmas in 80,000 pixels.
TEST(Fuse, WrongNormalsDoNotMovePoints) {
  const Scene scene = Scene::of_four({.slope = 0});
  const float sigma = 0.1f;
  MemoryStore store = true_maps(scene, sigma, 1);
  double worst = 0;
  for (const FusedPoint& p : fused(scene, store).points)
    worst = std::max(worst, std::abs(height_above_ground(scene, p)));
  EXPECT_LT(worst, sigma * 5);
}

TEST(Fuse, HolesStayHoles) {
  const Scene scene = Scene::of_four({.slope = 0});
  MemoryStore store = true_maps(scene, 0.01f, 0);
  const auto in_hole = [](const Eigen::Vector3d& p) { return std::hypot(p.x(), p.y()) < 0.5; };
  for (auto& [id, map] : store.maps)
    for (int y = 0; y < map.depth.height; ++y)
      for (int x = 0; x < map.depth.width; ++x)
        if (in_hole(scene.truth(id, map.camera, x, y).point_in_world))
          map.depth.at(x, y) = map.sigma.at(x, y) = std::numeric_limits<float>::quiet_NaN();
  for (const FusedPoint& p : fused(scene, store).points) EXPECT_FALSE(in_hole(p.position_in_world));
}

TEST(Fuse, ColourIsThatOfTheImage) {
  const Scene scene = Scene::of_four({.slope = 0});
  MemoryStore store = true_maps(scene, 0.01f, 0);
  std::map<ImageId, int> reads;
  const ColourSource colours = [&](ImageId id, int) -> Result<ColourImage> {
    ++reads[id];
    const Camera& camera = scene.block.camera_of(id);
    ColourImage image(camera.width_px, camera.height_px, 3);
    for (std::size_t i = 0; i < image.data.size(); i += 3) image.data[i] = 200, image.data[i + 1] = 100;
    return image;
  };
  const Cloud cloud = fused(scene, store, {}, 1, colours);
  ASSERT_FALSE(cloud.points.empty());
  for (const FusedPoint& p : cloud.points) EXPECT_EQ(p.colour, (std::array<std::uint8_t, 3>{200, 100, 0}));
  for (const auto& [id, times] : reads) EXPECT_EQ(times, 1);
}

TEST(Fuse, SameBitsWhateverTheNumberOfThreads) {
  const Scene scene = Scene::of_four({.slope = 0, .roof = 2});
  MemoryStore store = true_maps(scene, 0.03f, 1);
  const Cloud one = fused(scene, store, {}, 1), three = fused(scene, store, {}, 3);
  ASSERT_EQ(one.points.size(), three.points.size());
  for (std::size_t i = 0; i < one.points.size(); ++i) {
    EXPECT_EQ(one.points[i].position_in_world, three.points[i].position_in_world);
    EXPECT_EQ(one.points[i].sigma, three.points[i].sigma);
  }
}

TEST(Fuse, SmallMemoryChangesNothingWhenFewMapsOverlap) {
  Scene scene;
  for (const double x : {0.0, 3.0, 6.0}) scene.add_camera(x, 0, 0, Scene::camera());
  scene.add_ties();
  MemoryStore store = true_maps(scene, 0.01f, 0);
  const std::size_t much = fused(scene, store).points.size(),
                    little = fused(scene, store, {.memory_mb = 50}).points.size();
  EXPECT_EQ(much, little);
}

// Their depth maps have 1.6 MB each.
Scene seven_that_overlap() {
  Scene scene = {.slope = 0};
  const Camera camera = ideal_camera(500, 500, 400);
  for (int i = 0; i < 7; ++i) scene.add_camera(0.2 * i, 0, 0, camera);
  scene.add_ties();
  return scene;
}

// Of six images that overlap the first, three have a map.
TEST(Fuse, ImagesWithoutAMapTakeNoRoom) {
  const Scene scene = seven_that_overlap();
  MemoryStore store = true_maps(scene, 0.01f, 0);
  for (const std::uint32_t without : {1, 2, 3}) store.maps.erase(ImageId{without});
  const Cloud little = fused(scene, store, {.memory_mb = 10}), enough = fused(scene, store);
  EXPECT_TRUE(little.log.empty());
  ASSERT_EQ(little.points.size(), enough.points.size());
  for (std::size_t i = 0; i < enough.points.size(); ++i) ASSERT_EQ(little.points[i].images, enough.points[i].images);
}

// With six others one has 11.2 MB.
TEST(Fuse, TellsWhenMemoryLeavesOverlappingMapsOut) {
  const Scene scene = seven_that_overlap();
  MemoryStore store = true_maps(scene, 0.01f, 0);
  const Cloud little = fused(scene, store, {.memory_mb = 10}), enough = fused(scene, store, {.memory_mb = 12});
  ASSERT_EQ(little.log.size(), 1u);
  EXPECT_EQ(little.log.front(),
            "fuse: memory_mb = 10 holds 5 of the 6 depth maps that overlap one; all of them take 12 MB");
  EXPECT_TRUE(enough.log.empty());
}

}  // namespace
}  // namespace collinea
