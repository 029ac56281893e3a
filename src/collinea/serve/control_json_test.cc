// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/control_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "collinea/base/test_folder.h"
#include "collinea/block/world_frame.h"
#include "collinea/edit/make_edits.h"
#include "collinea/geometry/rotation.h"
#include "collinea/project/settings.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"
#include "collinea/serve/work_json.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using nlohmann::json;

/// Four vertical images over flat ground with exact measurements, and a control point marked in two of them.
Block exact_block() {
  Block block;
  block.georeference = {"EPSG:32633", 48.2, 15.63, 300};
  const LocalFrame frame = *world_frame(*block.georeference);
  block.cameras[CameraId{0}] = ideal_camera(1000, 1000, 800);
  const Eigen::Quaterniond down(0, 1, 0, 0);  // x east, y south, z down
  for (std::uint32_t i = 0; i < 4; ++i) {
    block.images[ImageId{i}] = {.file = "IMG_" + std::to_string(i) + ".jpg", .camera = CameraId{0}};
    const Vector3d centre(20.0 * i, 3.0 * (i % 2), 60);
    set_pose(block, ImageId{i}, {down, -(down * centre)});
  }
  const auto seen = [&](ImageId image, const Vector3d& point) {
    const auto pixel = project(block.camera_of(image), pose_of(block, image) * point);
    return pixel && inside(block.camera_of(image), *pixel) ? pixel : std::nullopt;
  };
  for (std::uint32_t k = 0; k < 60; ++k) {
    const Vector3d point(-20 + 10.0 * (k % 10), -15 + 6.0 * (k / 10), (k % 7) - 3.0);
    block.points[PointId{k}].position_in_world = point;
    for (std::uint32_t i = 0; i < 4; ++i)
      if (const auto pixel = seen(ImageId{i}, point))
        block.observations.push_back({ImageId{i}, PointId{k}, 0, *pixel, 0.5});
  }
  ControlPoint point{.name = "P/1 a"};  // a name may hold anything
  point.position_in_world = {25, 2, 0.5};
  point.position_in_map = frame.map_from_local(point.position_in_world);
  point.sigma_m = {0.02, 0.02, std::numeric_limits<double>::infinity()};
  block.control[ControlId{5}] = point;
  for (const std::uint32_t i : {0u, 1u})
    block.control_observations.push_back({ControlId{5}, ImageId{i}, *seen(ImageId{i}, point.position_in_world), 0.5});
  return block;
}

class ControlJsonTest : public ::testing::Test {
 protected:
  void SetUp() override {
    Settings settings;
    settings.photos = (folder_ / "").string();
    std::filesystem::create_directories(folder_ / "project");
    ASSERT_TRUE(write_settings(folder_ / "project", settings));
    auto store = ProjectStore::open(folder_ / "project");
    ASSERT_TRUE(store) << store.error().message;
    ASSERT_TRUE(store->write_setup(block_));
    ASSERT_TRUE(store->write_orientation(block_));
  }
  std::shared_ptr<const ProjectView> view() {
    auto view = views_.of({"1", "project", folder_ / "project"});
    EXPECT_TRUE(view) << view.error().message;
    return *view;
  }
  TestFolder folder_;
  Block block_ = exact_block();
  ProjectViews views_;
};

TEST_F(ControlJsonTest, TheMapHoldsTheImages) {
  const json map = json::parse(*map_json(*view()));
  EXPECT_EQ(map.at("crs"), "EPSG:32633");
  EXPECT_EQ(map.at("proj4"), "+proj=utm +zone=33 +datum=WGS84 +units=m +no_defs");
  const json images = json::parse(*images_json(*view())).at("images");
  ASSERT_EQ(images.size(), 4u);
  const json& bounds = map.at("bounds");
  for (const json& image : images) {
    EXPECT_TRUE(image.at("oriented"));
    EXPECT_EQ(image.at("levels"), 3);
    const Vector3d position = view()->in_map(centre_of(pose_of(block_, ImageId{image.at("id").get<std::uint32_t>()})));
    EXPECT_NEAR(image.at("position").at(0).get<double>(), position.x(), 1e-3);
    EXPECT_NEAR(image.at("position").at(2).get<double>(), position.z(), 1e-3);
    for (const json& corner : image.at("footprint")) {
      EXPECT_GE(corner.at(0).get<double>(), bounds.at(0).get<double>() - 1e-3);
      EXPECT_LE(corner.at(1).get<double>(), bounds.at(3).get<double>() + 1e-3);
    }
  }
  // 1000 px at 60 m are 60 m, and 800 px 48 m, but for the scale of the map and some decimetres of ground.
  EXPECT_NEAR(bounds.at(2).get<double>() - bounds.at(0).get<double>(), 60 + 3 * 20, 3);
  EXPECT_EQ(images.at(0).at("marks"), 1);
  EXPECT_EQ(images.at(2).at("marks"), 0);
}

TEST_F(ControlJsonTest, TiesAndResidualsAreBounded) {
  EXPECT_EQ(json::parse(*ties_json(*view(), 10)).at("points").size(), 10u);
  const json all = json::parse(*ties_json(*view(), 1'000'000'000)).at("points");
  EXPECT_EQ(all.size(), block_.points.size());
  EXPECT_TRUE(all.at(0).at(3).is_null());  // no covariances yet
  const json residuals = json::parse(*residuals_json(*view(), ImageId{1})).at("points");
  ASSERT_GT(residuals.size(), 10u);
  for (const json& one : residuals) EXPECT_LE(std::abs(one.at(2).get<double>()), 0.001);
}

TEST_F(ControlJsonTest, ControlIsAsItIsGiven) {
  const json points = json::parse(control_json(*view())).at("points");
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points.at(0).at("role"), "control");
  EXPECT_TRUE(points.at(0).at("sigma_m").at(2).is_null());
  EXPECT_TRUE(points.at(0).at("adjusted").is_null());
  EXPECT_EQ(points.at(0).at("marks").size(), 2u);
  EXPECT_TRUE(points.at(0).at("marks").at(0).at("w").is_null());
}

TEST_F(ControlJsonTest, MarksArePredictedInTheOthers) {
  const auto text = predicted_marks_json(*view(), "P/1 a");
  ASSERT_TRUE(text) << text.error().message;
  const json found = json::parse(*text);
  EXPECT_GE(found.at("places").size(), 3u);
  for (const json& one : found.at("places")) {
    const ImageId image{one.at("image").get<std::uint32_t>()};
    const Vector2d truth = *project(block_.camera_of(image), pose_of(block_, image) * Vector3d(25, 2, 0.5));
    EXPECT_NEAR(one.at("pixel").at(0).get<double>(), truth.x(), 1e-3);
    EXPECT_NEAR(one.at("pixel").at(1).get<double>(), truth.y(), 1e-3);
    EXPECT_GT(one.at("ellipse").at("major_px").get<double>(), 0);
  }
  EXPECT_EQ(found.at("marked").at("redundancy"), 1);
  EXPECT_NEAR(found.at("marked").at("difference_m").at(0).get<double>(), 0, 1e-4);
  EXPECT_TRUE(found.at("marked").at("difference_m").at(2).is_null());  // no height was given
  EXPECT_EQ(predicted_marks_json(*view(), "none").error().code, Errc::kNotFound);
}

// A house of 20 m beside the point, in the surface of the project: the photographs beyond it come last.
TEST_F(ControlJsonTest, WhatTheSurfaceHidesComesLastAmongThePlaces) {
  const Vector3d at = block_.control.at(ControlId{5}).position_in_map;
  const MapGrid grid{at.x() - 60, at.y() + 40, 0.5, 240, 160, world_frame(*block_.georeference)->wkt1()};
  FloatImage heights(grid.width, grid.height, 1, float(at.z()));
  for (int row = 0; row < grid.height; ++row)
    for (int column = 0; column < grid.width; ++column)
      if (const double east = grid.east_of(column + 0.5) - at.x(); east > 3 && east < 7)
        heights.at(column, row) = float(at.z() + 20);
  std::filesystem::create_directories(folder_ / "project" / "products");
  auto writer = GeoTiffWriter<float>::create(folder_ / "project" / "products" / "dsm.tif", grid, 1, {.nodata = -9999});
  ASSERT_TRUE(writer && writer->write(0, 0, heights) && writer->finish());
  const auto text = predicted_marks_json(*view(), "P/1 a");
  ASSERT_TRUE(text) << text.error().message;
  const json found = json::parse(*text);
  std::map<std::uint32_t, bool> hidden;
  bool before = false;
  for (const json& one : found.at("places")) {
    hidden[one.at("image")] = one.at("hidden");
    if (one.at("marked") == true) continue;
    EXPECT_TRUE(one.at("hidden") == true || !before);
    before = one.at("hidden");
  }
  // The point lies at x = 25, the photographs at 0, 20 and 40, 60 m up: the ray to the last passes the near side of the
  // house at 12 of its 20 m. That at 60 does not show the point.
  ASSERT_EQ(hidden.size(), 3u);
  EXPECT_FALSE(hidden.at(0) || hidden.at(1));
  EXPECT_TRUE(hidden.at(2));
}

// What is edited shows at once; the view is read anew.
TEST_F(ControlJsonTest, AMarkThatIsMadeIsSeen) {
  EXPECT_EQ(json::parse(control_json(*view())).at("points").at(0).at("marks").size(), 2u);
  block_.control_observations.push_back({ControlId{5}, ImageId{2}, {400, 400}, 0.5});
  {
    auto store = ProjectStore::open(folder_ / "project");
    ASSERT_TRUE(store && store->write_setup(block_));
  }
  EXPECT_EQ(json::parse(control_json(*view())).at("points").at(0).at("marks").size(), 3u);
}

TEST_F(ControlJsonTest, RefiningRefusesWhatItCannotUse) {
  ASSERT_TRUE(write_jpeg(folder_ / "IMG_0.jpg", Raster<std::uint8_t>(1000, 800, 3, 90), 90));
  const auto code = [&](const std::string& body) { return refined_json(*view(), body).error().code; };
  EXPECT_EQ(code(R"({"image": 0, "pixel": [400, 300]})"), Errc::kNotConverged);  // nothing there
  EXPECT_EQ(code(R"({"image": 0, "pixel": [0, 800], "kind": "cross"})"), Errc::kNotConverged);
  EXPECT_EQ(code(R"({"image": 9, "pixel": [400, 300]})"), Errc::kNotFound);
  EXPECT_EQ(code(R"({"image": 1, "pixel": [400, 300]})"), Errc::kNotFound);  // its file is missing
  for (const char* body :
       {"", "{}", "[]", R"({"image": 0, "pixel": [1e9, 3]})", R"({"image": 0, "pixel": [1001, 3]})",
        R"({"image": 0, "pixel": [4]})", R"({"image": 0, "pixel": "x"})", R"({"image": -1, "pixel": [4, 4]})",
        R"({"image": 0, "pixel": [4, 4], "kind": "star"})", R"({"image": 0, "pixel": [[[[[[[[4]]]]]]]]})"}) {
    const auto answer = refined_json(*view(), body);
    EXPECT_FALSE(answer) << body;
    EXPECT_TRUE(answer.error().code == Errc::kBadInput || answer.error().code == Errc::kNotFound) << body;
  }
}

// A point as the whole block has it is what the adjustment made of it (which iterates its tie points, too: 5 % of a
// sigma); a mark that is moved shows at once, and the block is not read again for it.
TEST(ControlJson, TheWholeBlockSaysAfterEachMarkWhatTheAdjustmentWould) {
  const TestFolder folder;
  const std::filesystem::path path = folder / "block";
  {
    auto project = open_small_survey(path);
    ASSERT_TRUE(project) << project.error().message;
    ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  }
  ProjectViews views;
  const auto view = [&] { return *views.of({"1", "block", path}); };
  const auto in_block = [&](const std::string& name) {
    return json::parse(*predicted_marks_json(*view(), name)).at("in_block");
  };
  const auto before = view();
  ASSERT_TRUE(before->adjustment);
  int compared = 0;
  for (const ControlDifference& one : before->adjustment->control) {
    if (!one.used) continue;
    const json found = in_block(before->control.at(one.point).name);
    ASSERT_FALSE(found.is_null());
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = one.difference_sigma_m[axis];
      EXPECT_NEAR(found.at("difference_m").at(axis).get<double>(), one.difference_m[axis], 0.05 * sigma);
      EXPECT_NEAR(found.at("difference_sigma_m").at(axis).get<double>(), sigma, 0.05 * sigma);
      ++compared;
    }
  }
  EXPECT_GE(compared, 9);
  const ControlObservation mark = before->marks.front();
  const std::string point = before->control.at(mark.point).name, image = before->block.images.at(mark.image).file;
  const auto test_of_mark = [&] {
    const json found = in_block(point);
    for (const json& one : found.at("marks"))
      if (one.at("image") == mark.image.value) return one.at("w").at(0).get<double>();
    return 0.0;
  };
  const double w = test_of_mark();
  const auto ties = view()->ties();
  Journal journal(path);
  const auto edit = parse_edit(std::vector<std::string>{"mark", point, image, std::to_string(mark.pixel.x() + 20),
                                                        std::to_string(mark.pixel.y()), "0.5"});
  ASSERT_TRUE(edit) << edit.error().message;
  const auto made = make_edits(path, journal, std::vector{*edit});
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_NE(view(), before);
  EXPECT_EQ(*view()->ties(), *ties);
  EXPECT_GT(std::abs(test_of_mark()), std::abs(w) + 5);
  // The table of all points says the same, that of the adjustment what it was.
  const auto in_table = [&](const std::string& text) {
    const json table = json::parse(text);
    for (const json& one : table.at("points"))
      if (one.at("name") == point)
        for (const json& seen : one.at("marks"))
          if (seen.at("image") == mark.image.value) return seen.at("w");
    return json();
  };
  const json now = in_table(*control_now_json(*view()));
  ASSERT_TRUE(now.is_number());
  EXPECT_GE(std::abs(now.get<double>()), std::abs(test_of_mark()) - 1e-9);  // the larger of column and row
  EXPECT_TRUE(in_table(control_json(*view())).is_null());                   // moved since
  // The mark that is taken back is one that helps: made anew, standard deviations are what they were to be.
  ASSERT_TRUE(make_edits(path, journal, std::vector{parse_edit(std::vector<std::string>{"undo"}).value()}));
  const json next = json::parse(*next_mark_json(*view())).at("next");
  if (!next.is_null()) {
    EXPECT_LE(next.at("rms_sigma_m").at(1).get<double>(), next.at("rms_sigma_m").at(0).get<double>());
    EXPECT_TRUE(view()->block.images.contains(ImageId{next.at("image").get<std::uint32_t>()}));
  }
  EXPECT_EQ(json::parse(work_json(*view())).at("masks").size(), 0u);
  const auto mask = parse_edit(std::vector<std::string>{"mask", "M", image, "0", "0", "10", "0", "10", "20"});
  ASSERT_TRUE(make_edits(path, journal, std::vector{mask.value()}));
  const json work = json::parse(work_json(*view()));
  EXPECT_EQ(work.at("masks").at(0).at("image"), mark.image.value);
  EXPECT_EQ(work.at("masks").at(0).at("ring").at(2), (json{10.0, 20.0}));
  EXPECT_TRUE(work.at("patches").empty());
}

// Projects without anything in them answer, too.
TEST(ControlJson, AnEmptyProjectHasNothing) {
  const TestFolder folder;
  ASSERT_TRUE(write_settings(folder / "", {}));
  ProjectViews views;
  const auto view = views.of({"1", "empty", folder / ""});
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_TRUE(json::parse(*map_json(**view)).at("bounds").is_null());
  EXPECT_TRUE(json::parse(*images_json(**view)).at("images").empty());
  EXPECT_TRUE(json::parse(*ties_json(**view, 5)).at("points").empty());
  EXPECT_TRUE(json::parse(control_json(**view)).at("points").empty());
  EXPECT_FALSE(control_now_json(**view));
  EXPECT_EQ(next_mark_json(**view).error().code, Errc::kIllPosed);
  EXPECT_TRUE(json::parse(work_json(**view)).at("masks").empty());
}

}  // namespace
}  // namespace collinea
