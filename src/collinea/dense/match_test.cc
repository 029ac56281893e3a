// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/match.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <vector>

#include "collinea/dense/internal/test_scene.h"

namespace collinea {
namespace {

using test::Scene;

constexpr ImageId kFirst{0};
constexpr double kBase = 2, kFocal = 200;  // of Scene::of_four: the parallax of a depth error is f B dz / z^2

DepthMap matched(const Scene& scene, int threads = 1) {
  collinea::Run run;
  run.threads = threads;
  auto map = depth_map(scene.block, kFirst, scene.pixels(), {}, run);
  EXPECT_TRUE(map) << (map ? "" : map.error().message);
  return map ? *std::move(map) : DepthMap{};
}

// Errors of all measured pixels of the map that `take` accepts, as parallax [px].
struct Errors {
  std::vector<double> parallax_px, in_sigmas;
  int pixels = 0;

  double part_measured() const { return double(parallax_px.size()) / pixels; }
  double rms_px() const { return rms(parallax_px); }
  double rms_sigmas() const { return rms(in_sigmas); }
  double part_beyond(double limit_px) const {
    return double(std::count_if(parallax_px.begin(), parallax_px.end(),
                                [&](double e) { return std::abs(e) > limit_px; })) /
           double(parallax_px.size());
  }
  static double rms(const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v * v;
    return std::sqrt(sum / double(values.size()));
  }
};

template <class Take>
Errors errors(const Scene& scene, const DepthMap& map, Take&& take) {
  Errors result;
  for (int y = 0; y < map.depth.height; ++y)
    for (int x = 0; x < map.depth.width; ++x) {
      const auto truth = scene.truth(kFirst, map.camera, x, y);
      if (!take(truth)) continue;
      ++result.pixels;
      const double depth = double(map.depth.at(x, y));
      if (std::isnan(depth)) continue;
      result.parallax_px.push_back(kFocal * kBase * (depth - truth.depth) / (truth.depth * truth.depth));
      result.in_sigmas.push_back((depth - truth.depth) / double(map.sigma.at(x, y)));
    }
  return result;
}

bool everywhere(const Scene::Truth&) { return true; }

TEST(DepthMap, SlopingPlaneIsRecoveredToATenthOfAPixel) {
  const Scene scene = Scene::of_four({.slope = 0.2});
  const Errors e = errors(scene, matched(scene), everywhere);
  EXPECT_LT(e.rms_px(), 0.1);
  EXPECT_GT(e.part_measured(), 0.9);  // the frame of 3 px that has no full window is 7 %
}

TEST(DepthMap, DistortionIsRejected) {
  Camera camera = Scene::camera();
  camera.params[Camera::kK1] = -0.12;
  camera.params[Camera::kP1] = 0.002;
  camera.params[Camera::kB1] = 0.8;
  camera.params[Camera::kCx] += 5;
  const Scene scene = Scene::of_four({}, camera);
  const DepthMap map = matched(scene);
  EXPECT_EQ(map.camera.params[Camera::kK1], 0);
  const Errors e = errors(scene, map, everywhere);
  EXPECT_LT(e.rms_px(), 0.1);
  EXPECT_GT(e.part_measured(), 0.85);
}

TEST(DepthMap, NeighboursMayBeTurned) {
  Scene scene;
  scene.add_camera(0, 0, 0, Scene::camera());
  scene.add_camera(2, 0, 3.14, Scene::camera());
  scene.add_camera(-2, 0, 1.5, Scene::camera());
  scene.add_ties();
  const Errors e = errors(scene, matched(scene), everywhere);
  EXPECT_LT(e.rms_px(), 0.1);
  EXPECT_GT(e.part_measured(), 0.85);
}

// Ten thousand points seen by nine images each, of twenty in a row that have a pose.
Block block_of_many_ties() {
  Scene scene;
  for (int i = 0; i < 20; ++i) scene.add_camera(0.4 * i, 0, 0, Scene::camera());
  Block block = scene.block;
  Random random(5);
  for (std::uint32_t n = 0; n < 10'000; ++n) {
    const Eigen::Vector3d point(8 * random.uniform(), random.uniform(), random.uniform());
    block.points[PointId{n}] = {point, {}};
    const auto first = std::uint32_t(12 * random.uniform());
    for (std::uint32_t i = first; i < first + 9; ++i)
      block.observations.push_back({ImageId{i}, PointId{n}, 0, {200 * random.uniform(), 160 * random.uniform()}, 1});
  }
  remove_pose(block, ImageId{7});
  return block;
}

// Points that nobody sees and observations by images without pose are passed over.
TEST(TieView, OnDiskIsThatInMemory) {
  const Block block = block_of_many_ties();
  const TieView whole(block);
  auto on_disk = TieView::on_disk(block, std::filesystem::temp_directory_path() / "collinea_tie_view");
  ASSERT_TRUE(on_disk) << on_disk.error().message;
  for (auto seen = block.observations.begin(); const auto& [id, point] : block.points) {
    on_disk->add(point.position_in_world, {seen, seen + 9});
    on_disk->add(point.position_in_world, {});
    seen += 9;
  }
  for (const auto& [image, of_file] : block.images) {
    const auto expected = *whole.seen_by(image), seen = *on_disk->seen_by(image);
    EXPECT_EQ(seen, expected);
    EXPECT_EQ(seen.size() > 500, is_oriented(block, image));
    EXPECT_EQ(*on_disk->neighbours(image, 5), *whole.neighbours(image, 5));
    EXPECT_EQ(*on_disk->overlapping(image, 30), *whole.overlapping(image, 30));
  }
  EXPECT_EQ(whole.overlapping(ImageId{10}, 30)->size(), 15u);  // 2 to 18 without itself and 7
}

TEST(TieView, OnDiskHoldsNoMoreOfManyTiesThanOfFew) {
  const Block block = block_of_many_ties();
  EXPECT_GT(TieView(block).bytes_in_memory(), 4 * TieView::kBuffered);
  auto ties = TieView::on_disk(block, std::filesystem::temp_directory_path() / "collinea_tie_view");
  ASSERT_TRUE(ties) << ties.error().message;
  for (auto seen = block.observations.begin(); const auto& [id, point] : block.points) {
    ties->add(point.position_in_world, {seen, seen + 9});
    seen += 9;
    ASSERT_LT(ties->bytes_in_memory(), 2 * TieView::kBuffered + 64 * 1024);  // strings grow to twice what is in them
  }
}

// Pyramids end where the shorter side does, while the longer one is still wider than overviews are.
TEST(Overview, OfALongStripIsTheSmallestImageThereIs) {
  const Camera strip = ideal_camera(3000, 3000, 200);
  Scene scene = {.slope = 0};
  for (const double x : {0.0, 1.0, -1.0}) scene.add_camera(x, 0, 0, strip);
  scene.add_ties(0.15);
  const TieView ties(scene.block);
  const PixelSource pixels = scene.pixels();
  WorkingImages images(scene.block, pixels, {});
  SharedBudget costs = budget_for_costs({}, 1);
  const auto map = overview(scene.block, kFirst, ties, images, costs, {}, {});
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_EQ(map->depth.width, 750);
  EXPECT_EQ(map->depth.height, 50);
  int right = 0;
  for (int x = 0; x < map->depth.width; ++x)
    right += std::abs(double(map->depth.at(x, 25)) / scene.truth(kFirst, map->camera, x, 25).depth - 1) < 0.01;
  EXPECT_GT(right, 0.9 * map->depth.width);
}

TEST(DepthMap, EdgeOfARoofStaysAnEdge) {
  const Scene scene = Scene::of_four({.slope = 0, .roof = 2});
  const DepthMap map = matched(scene);
  const auto distance_m = [](const Scene::Truth& t) {  // outside the block: from its edge
    const double dx = std::abs(t.point_in_world.x()) - 1, dy = std::abs(t.point_in_world.y()) - 0.8;
    return std::max(dx, dy);
  };
  const double pixel_m = 0.05;
  const auto away = [&](const Scene::Truth& t) { return std::abs(distance_m(t)) > 4 * pixel_m; };
  EXPECT_LT(errors(scene, map, away).part_beyond(1), 0.01);
  EXPECT_GT(errors(scene, map, away).part_measured(), 0.85);
  // beside the edge there is ground or roof (12.5 px of parallax apart), nothing in between
  const auto beside = [&](const Scene::Truth& t) { return std::abs(distance_m(t)) < 4 * pixel_m; };
  const Errors e = errors(scene, map, beside);
  int between = 0;
  for (const double px : e.parallax_px) between += std::abs(px) > 2 && std::abs(px) < 6;
  EXPECT_LT(between, 0.05 * double(e.parallax_px.size()));
}

TEST(DepthMap, NothingIsInventedWhereThereIsNoTexture) {
  const Scene scene = Scene::of_four({.blank_radius = 1.6, .noise = 1.5});
  const auto inside_of_blank = [](const Scene::Truth& t) {
    return std::hypot(t.point_in_world.x() + 1, t.point_in_world.y()) < 1.2;  // 8 px: beyond the reach of windows
  };
  EXPECT_LT(errors(scene, matched(scene), inside_of_blank).part_measured(), 0.05);
}

// Windows of 7 x 7 overlap, so of some 28,000 errors only about 500 are independent: their mean square is known to
// sqrt(2 / 500) = 6 %, the root to 3 %; four of those are 12 %. Noise of 8 grey values makes 0.12 px, and the floor of
// 0.05 px adds next to nothing.
TEST(DepthMap, SigmaTellsTheTruthWhereNoiseDecides) {
  const Scene scene = Scene::of_four({.slope = 0.05, .noise = 8});
  const Errors e = errors(scene, matched(scene), everywhere);
  EXPECT_GT(e.part_measured(), 0.85);
  EXPECT_NEAR(e.rms_sigmas(), 1, 0.12);
}

// Noise of 4 makes 0.055 px where the formula gives that, too, before its factor of 1.2 and its floor of 0.05 px, which
// stands for errors of interpolation and adds to noise what these images have little of: sigma is
// hypot(1.2 0.055, 0.05) / 0.055 = 1.5 times too large, and no more than that and the 12 % of above.
TEST(DepthMap, SigmaIsRatherTooLargeOnClearImages) {
  const Scene scene = Scene::of_four({.slope = 0.05, .noise = 4});
  const Errors e = errors(scene, matched(scene), everywhere);
  EXPECT_GT(e.part_measured(), 0.85);
  EXPECT_GT(e.rms_sigmas(), 1 / 1.5 - 0.08);
  EXPECT_LT(e.rms_sigmas(), 1.1);
}

TEST(DepthMap, SameBitsWhateverTheNumberOfThreads) {
  const Scene scene = Scene::of_four({.slope = 0, .roof = 2});
  const DepthMap one = matched(scene, 1), three = matched(scene, 3);
  ASSERT_EQ(one.depth.data.size(), three.depth.data.size());
  EXPECT_EQ(std::memcmp(one.depth.data.data(), three.depth.data.data(), one.depth.data.size() * sizeof(float)), 0);
  EXPECT_EQ(std::memcmp(one.sigma.data.data(), three.sigma.data.data(), one.sigma.data.size() * sizeof(float)), 0);
}

TEST(DepthMap, ImageAloneIsIllPosed) {
  Scene scene;
  scene.add_camera(0, 0, 0, Scene::camera());
  scene.add_ties();
  const auto map = depth_map(scene.block, kFirst, scene.pixels(), {}, {});
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().code, Errc::kIllPosed);
}

TEST(DepthMap, ImagesFromOnePositionAreIllPosed) {
  Scene scene;
  scene.add_camera(0, 0, 0, Scene::camera());
  scene.add_camera(0, 0, 0.3, Scene::camera());
  scene.add_ties();
  const auto map = depth_map(scene.block, kFirst, scene.pixels(), {}, {});
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().code, Errc::kIllPosed);
}

TEST(DepthMap, StopIsHeard) {
  const Scene scene = Scene::of_four({});
  std::stop_source stop;
  stop.request_stop();
  collinea::Run run;
  run.stop = stop.get_token();
  const auto map = depth_map(scene.block, kFirst, scene.pixels(), {}, run);
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().code, Errc::kCancelled);
}

TEST(DepthMap, ImageThatDoesNotFitItsCameraIsRefused) {
  const Scene scene = Scene::of_four({});
  const auto map =
      depth_map(scene.block, kFirst, [](ImageId, int) -> Result<GreyImage> { return GreyImage(100, 80); }, {}, {});
  ASSERT_FALSE(map);
  EXPECT_EQ(map.error().code, Errc::kBadInput);
}

TEST(DepthMap, WordsForTheResolution) {
  const Camera camera = ideal_camera(4000, 6000, 4000);
  EXPECT_EQ(*working_shrink(camera, {}), 4);  // 24 MP; a half would still be 6
  EXPECT_EQ(*working_shrink(camera, {.resolution = Resolution::kHalf}), 2);
  EXPECT_EQ(*working_shrink(camera, {.resolution = Resolution::kQuarter}), 4);
}

}  // namespace
}  // namespace collinea
