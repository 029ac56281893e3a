// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/project_plane.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/block/world_frame.h"
#include "collinea/cloud/las.h"
#include "collinea/geometry/plane.h"
#include "collinea/jobs/rectify_plane.h"
#include "collinea/math/random.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/test_small_project.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

class PlaneOfAProject : public SmallProject {
 public:
  void SetUp() override { map(Step::kDensify); }

  void a_plane_through_control_shows_what_the_images_show_there();
  void a_plane_through_positions_of_the_map_is_that_through_control();
  void the_plane_of_a_region_is_the_one_that_most_points_of_the_cloud_lie_on();
  void planes_that_cannot_be_drawn_are_refused_in_words();
  void a_plane_of_a_block_without_scale_says_so();
};

// A plane that was drawn, and what is reported of it.
struct DrawnPlane {
  nlohmann::json reported;
  FramedPlane frame;
  MapGrid grid;
  Raster<std::uint8_t> rgba;

  [[nodiscard]] Eigen::Vector3d normal() const { return frame.world_from_plane.col(2); }
  [[nodiscard]] double off_m(const Eigen::Vector3d& point_in_world) const {
    return std::abs(frame.in_plane(point_in_world).z());
  }
  [[nodiscard]] Eigen::Vector3d world_at(double x, double y) const {
    return frame.origin_in_world + frame.world_from_plane * Eigen::Vector3d(x, y, 0);
  }
};

DrawnPlane drawn_plane(const fs::path& image) {
  DrawnPlane drawn;
  drawn.reported = nlohmann::json::parse(read_file(fs::path(image).replace_extension(".json")).value());
  const auto vector_of = [&](const char* name) {
    const nlohmann::json& list = drawn.reported.at("plane").at(name);
    return Eigen::Vector3d(list[0].get<double>(), list[1].get<double>(), list[2].get<double>());
  };
  drawn.frame.origin_in_world = vector_of("origin_in_world");
  drawn.frame.world_from_plane << vector_of("x_axis_in_world"), vector_of("y_axis_in_world"),
      vector_of("normal_in_world");
  const auto reader = GeoTiffReader::open(image).value();
  drawn.grid = reader.grid();
  drawn.rgba = reader.read_byte(0, 0, drawn.grid.width, drawn.grid.height).value();
  return drawn;
}

// The RMS difference of a drawn plane to what the first of its images that shows a point has `aside` cells beside.
double difference_to_images(const DrawnPlane& plane, const Block& block, const fs::path& photos, double aside) {
  double squares = 0, count = 0;
  std::map<std::string, ColourImage> images;
  for (int row = 2; row < plane.grid.height; row += 5) {
    for (int column = 2; column < plane.grid.width; column += 5) {
      if (plane.rgba.at(column, row, 3) == 0) continue;
      const Eigen::Vector3d position =
          plane.world_at(plane.grid.east_of(column + 0.5 + aside), plane.grid.north_of(row + 0.5));
      for (const auto& raster : plane.reported.at("photographs")) {
        const std::string file = raster.at("file");
        const auto image = std::find_if(block.images.begin(), block.images.end(),
                                        [&](const auto& entry) { return entry.second.file == file; });
        const Camera& camera = block.camera_of(image->first);
        const auto pixel = project(camera, pose_of(block, image->first) * position);
        if (!pixel || !inside(camera, *pixel)) continue;
        if (!images.contains(file)) images[file] = read_colour(photos / file).value();
        float colour[3];
        bicubic(images[file], pixel->x(), pixel->y(), colour);
        for (int c = 0; c < 3; ++c) squares += std::pow(double(colour[c]) - plane.rgba.at(column, row, c), 2), ++count;
        break;
      }
    }
  }
  EXPECT_GT(count, 3000);
  return std::sqrt(squares / count);
}

// The names of three surveyed points.
std::string three_points(const Block& block) {
  std::string names;
  for (auto it = block.control.begin(); it != std::next(block.control.begin(), 3); ++it)
    names += (names.empty() ? "" : ",") + it->second.name;
  return names;
}

void PlaneOfAProject::a_plane_through_control_shows_what_the_images_show_there() {
  const Block block = open_project(root_ / "mapped", {})->store.read_block().value();
  const auto done = rectify_plane(root_ / "mapped", root_ / "plane.tif", {.control = three_points(block)}, {});
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_TRUE(done->is_metric);
  const DrawnPlane plane = drawn_plane(root_ / "plane.tif");
  EXPECT_EQ(plane.reported.at("plane").at("points"), 3);
  EXPECT_GT(plane.normal().z(), 0.9);
  for (auto it = block.control.begin(); it != std::next(block.control.begin(), 3); ++it)
    EXPECT_LT(plane.off_m(it->second.position_in_world), 1e-6) << it->second.name;
  // Rounded to whole levels: 1 / sqrt(12). Half a cell beside it is ten times that.
  EXPECT_LT(difference_to_images(plane, block, root_ / "images", 0), 0.35);
  EXPECT_GT(difference_to_images(plane, block, root_ / "images", 0.5), 2);
}

void PlaneOfAProject::a_plane_through_positions_of_the_map_is_that_through_control() {
  const Block block = open_project(root_ / "mapped", {})->store.read_block().value();
  const auto frame = world_frame(block.georeference.value());
  ASSERT_TRUE(frame);
  std::string positions;
  for (auto it = block.control.begin(); it != std::next(block.control.begin(), 3); ++it) {
    const Eigen::Vector3d on_map = frame->map_from_local(it->second.position_in_world);
    positions += fmt::format("{:.6f} {:.6f} {:.6f}\n", on_map.x(), on_map.y(), on_map.z());
  }
  ASSERT_TRUE(write_file(root_ / "places.txt", positions));
  ASSERT_TRUE(rectify_plane(root_ / "mapped", root_ / "plane.tif", {.control = three_points(block)}, {}));
  ASSERT_TRUE(rectify_plane(root_ / "mapped", root_ / "same.tif", {.map_points = root_ / "places.txt"}, {}));
  const DrawnPlane plane = drawn_plane(root_ / "plane.tif"), same = drawn_plane(root_ / "same.tif");
  // The file has micrometres.
  EXPECT_LT((same.frame.origin_in_world - plane.frame.origin_in_world).norm(), 1e-5);
  EXPECT_LT((same.frame.world_from_plane - plane.frame.world_from_plane).norm(), 1e-6);
  EXPECT_EQ(same.grid.width, plane.grid.width);
  EXPECT_EQ(same.grid.height, plane.grid.height);
}

void PlaneOfAProject::the_plane_of_a_region_is_the_one_that_most_points_of_the_cloud_lie_on() {
  constexpr double kTolerance_m = 0.5;
  const Block block = open_project(root_ / "mapped", {})->store.read_block().value();
  const auto frame = world_frame(block.georeference.value());
  auto reader = LasReader::open(root_ / "mapped/products/cloud.copc.laz");
  ASSERT_TRUE(frame && reader);
  const LasHeader header = reader->header();
  const auto points = reader->read(10'000'000);
  ASSERT_TRUE(points);
  std::vector<Eigen::Vector3d> cloud;
  for (const CloudPoint& point : *points) cloud.push_back(point.position);
  frame->local_from_map(cloud);
  const auto region = fmt::format("{},{},{},{}", header.lowest[0] - 1, header.lowest[1] - 1, header.highest[0] + 1,
                                  header.highest[1] + 1);
  const auto done =
      rectify_plane(root_ / "mapped", root_ / "plane.tif", {.region = region, .tolerance_m = kTolerance_m}, {});
  ASSERT_TRUE(done) << done.error().message;
  const DrawnPlane plane = drawn_plane(root_ / "plane.tif");
  const auto on_it = [&](const Eigen::Vector3d& middle, const Eigen::Vector3d& normal) {
    return std::count_if(cloud.begin(), cloud.end(), [&](const Eigen::Vector3d& point) {
      return std::abs(normal.dot(point - middle)) < kTolerance_m;
    });
  };
  const auto reported = plane.reported.at("plane");
  const auto count = on_it(plane.frame.origin_in_world, plane.normal());
  double squares = 0;
  for (const Eigen::Vector3d& point : cloud)
    if (plane.off_m(point) < kTolerance_m) squares += plane.off_m(point) * plane.off_m(point);
  // What is reported is of the points that the last fit was made of, which then moved the plane a little.
  EXPECT_NEAR(reported.at("points").get<double>(), double(count), 0.01 * double(count));
  EXPECT_NEAR(reported.at("rms_m").get<double>(), std::sqrt(squares / double(count)), 0.01 * kTolerance_m);
  // No other that three of its points make holds more.
  Random random(1);
  long most = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const auto any = [&] { return cloud[random.below(std::uint32_t(cloud.size()))]; };
    const Eigen::Vector3d a = any(), b = any(), c = any();
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() > 1) most = std::max(most, long(on_it(a, normal.normalized())));
  }
  EXPECT_GE(count, most);
  EXPECT_GT(most, 0);
}

void PlaneOfAProject::planes_that_cannot_be_drawn_are_refused_in_words() {
  const std::string names = three_points(open_project(root_ / "mapped", {})->store.read_block().value());
  const auto why = [&](const RectifyOptions& options) {
    const auto done = rectify_plane(root_ / "mapped", root_ / "refused.tif", options, {});
    return done ? std::string("done") : done.error().message;
  };
  EXPECT_NE(why({}).find("which plane"), std::string::npos);
  EXPECT_NE(why({.control = names, .region = "0,0,1,1"}).find("which plane"), std::string::npos);
  EXPECT_NE(why({.control = names, .sigma_px = 1.0}).find("standard deviations are of the points"), std::string::npos);
  EXPECT_NE(why({.control = names, .sigma_m = 0.0}).find("standard deviations are of the points"), std::string::npos);
  EXPECT_NE(why({.focal_px = 100.0, .control = names}).find("for a photograph"), std::string::npos);
  EXPECT_NE(why({.control = "nobody," + names}).find("no control point \"nobody\""), std::string::npos);
  EXPECT_NE(why({.region = "0,0,1,1"}).find("0 points"), std::string::npos);
  EXPECT_FALSE(fs::exists(root_ / "refused.tif"));
}

// Whether lengths are metres is what the orientation says, not whether the block is georeferenced.
void PlaneOfAProject::a_plane_of_a_block_without_scale_says_so() {
  const fs::path local = copy("local");
  const std::string names = three_points(open_project(local, {})->store.read_block().value());
  for (const bool metric : {true, false}) {
    auto store = ProjectStore::open(local);
    ASSERT_TRUE(store);
    auto step = store->read_step("orient").value().value();
    auto& orientation = std::get<OrientationRecord>(step.outcome);
    orientation.georeferenced = false, orientation.metric = metric;
    ASSERT_TRUE(store->write_step(step));
    const auto done = rectify_plane(local, root_ / "plane.tif", {.control = names}, {});
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->is_metric, metric);
    EXPECT_EQ(rectified_text(*done).find("no scale") == std::string::npos, metric);
  }
}

TEST_F(PlaneOfAProject, IsFoundDrawnAndRefusedAsPromised) {
  a_plane_through_control_shows_what_the_images_show_there();
  a_plane_through_positions_of_the_map_is_that_through_control();
  the_plane_of_a_region_is_the_one_that_most_points_of_the_cloud_lie_on();
  planes_that_cannot_be_drawn_are_refused_in_words();
  a_plane_of_a_block_without_scale_says_so();
}

}  // namespace
}  // namespace collinea
