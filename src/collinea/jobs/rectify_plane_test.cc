// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/rectify_plane.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/camera/camera.h"
#include "collinea/io/colmap.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// An image of a wall with a grid painted on it, at whose corners points are measured; the wall is the plane x, z of
// the world, seen from the south. Beside it the orientation as a COLMAP model.
class RectifyPlane : public ::testing::Test {
 protected:
  void SetUp() override {
    camera_ = ideal_camera(700, 800, 600);
    camera_.params[Camera::kK1] = -0.09;
    const Vector3d centre(1, -6, 1.6), forward = (Vector3d(3, 0, 2.5) - centre).normalized();
    const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d rotation;
    rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    pose_ = {Eigen::Quaterniond(rotation), -(rotation * centre)};
    ColourImage image(800, 600, 3);
    for (int y = 0; y < 600; ++y)
      for (int x = 0; x < 800; ++x) {
        const Vector3d ray = rotation.transpose() * ray_in_cam(camera_, {x + 0.5, y + 0.5});
        const Vector3d at = centre - ray * (centre.y() / ray.y());
        const bool white = ray.y() > 0 && std::sin(M_PI * at.x()) * std::sin(M_PI * at.z()) > 0;
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = white ? 220 : 40;
      }
    ASSERT_TRUE(write_jpeg(folder_ / "wall.jpg", image, 95));
    Block block;
    block.cameras[CameraId{0}] = camera_;
    block.images[ImageId{0}] = {"wall.jpg", CameraId{0}};
    set_pose(block, ImageId{0}, pose_);
    ASSERT_TRUE(write_colmap(folder_ / "model", block, ColmapEncoding::kText));
  }
  [[nodiscard]] Vector2d pixel(double x, double y) const { return project(camera_, pose_ * Vector3d(x, 0, y)).value(); }
  void put_points(int count, double wrong_px = 0) {
    std::string text = "# wall\nname,column_px,row_px,x_m,y_m\n";
    const Vector2d positions[] = {{1, 1}, {5, 1}, {5, 4}, {1, 4}, {3, 2}, {2, 3}, {4, 3}, {2, 1}};
    for (int i = 0; i < count; ++i) {
      const Vector2d p = pixel(positions[i].x(), positions[i].y());
      text += "p" + std::to_string(i) + ", " + std::to_string(p.x() + (i == 4 ? wrong_px : 0)) + ", " +
              std::to_string(p.y()) + ", " + std::to_string(positions[i].x()) + ", " +
              std::to_string(positions[i].y()) + "\n";
    }
    ASSERT_TRUE(write_file(folder_ / "points.csv", text));
  }
  [[nodiscard]] Result<RectifiedReport> rectified(const RectifyOptions& options, const char* out = "out.tif") const {
    return rectify_plane(folder_ / "wall.jpg", folder_ / out, options, collinea::Run{});
  }
  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(*read_file(folder_ / "out.json")); }

  TestFolder folder_;
  Camera camera_;
  Rigid3 pose_;
};

TEST_F(RectifyPlane, AnImageOfAKnownCameraIsMetricAndFreeOfDistortion) {
  put_points(8);
  RectifyOptions options;
  options.points = folder_ / "points.csv";
  options.orientation = folder_ / "model";
  options.cell_m = 0.01;
  options.extent = "0.5,0.5,5.5,4.5";
  const auto done = rectified(options);
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_TRUE(done->from_points);
  EXPECT_TRUE(done->from_points->is_lens_known);
  const auto tiff = GeoTiffReader::open(folder_ / "out.tif");
  ASSERT_TRUE(tiff);
  EXPECT_EQ(tiff->grid().width, 500);
  EXPECT_NEAR(tiff->grid().north_m, 4.5, 1e-9);
  const auto rgba = tiff->read_byte(0, 0, 500, 400);
  ASSERT_TRUE(rgba);
  int wrong = 0, looked_at = 0;
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 500; ++x) {
      const double east = tiff->grid().east_of(x + 0.5), up = tiff->grid().north_of(y + 0.5);
      if (std::abs(east - std::round(east)) < 0.03 || std::abs(up - std::round(up)) < 0.03) continue;  // blurred edges
      const bool white = std::sin(M_PI * east) * std::sin(M_PI * up) > 0;
      ++looked_at;
      wrong += rgba->at(x, y, 3) != 255 || (rgba->at(x, y, 0) > 130) != white;
    }
  EXPECT_GT(looked_at, 150'000);
  EXPECT_EQ(wrong, 0);
  const auto reported = json();
  EXPECT_LT(reported.at("sigma0").get<double>(), 1e-3);
  EXPECT_LT(reported.at("sigma_position_m").at("middle").get<double>(), 0.005);
  const auto centre = reported.at("photographs")[0].at("centre_over_plane_m");
  EXPECT_NEAR(centre[0].get<double>(), 1, 1e-3);
  EXPECT_NEAR(centre[2].get<double>(), 6, 1e-3);
}

TEST_F(RectifyPlane, ADistortingLensThatIsNotKnownShowsInTheResiduals) {
  put_points(8);
  RectifyOptions options;
  options.points = folder_ / "points.csv";
  options.sigma_px = 0.1;
  const auto done = rectified(options);
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_TRUE(done->from_points);
  EXPECT_FALSE(done->from_points->is_lens_known);
  EXPECT_GT(json().at("sigma0").get<double>(), 2);
  EXPECT_TRUE(done->from_points->residuals_are_too_large);
  EXPECT_NE(rectified_text(*done).find("larger than the sigmas"), std::string::npos);
}

TEST_F(RectifyPlane, AWrongPointIsNamed) {
  put_points(8, 15);
  RectifyOptions options;
  options.points = folder_ / "points.csv";
  options.orientation = folder_ / "model";
  const auto done = rectified(options);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_NE(rectified_text(*done).find("at point p4"), std::string::npos) << rectified_text(*done);
}

TEST_F(RectifyPlane, ARectangleOfKnownSidesIsEnough) {
  RectifyOptions options;
  std::string corners;
  for (const auto& [x, y] : {std::pair(1, 4), std::pair(5, 4), std::pair(5, 1), std::pair(1, 1)})
    corners += (corners.empty() ? "" : ",") + std::to_string(pixel(x, y).x()) + "," + std::to_string(pixel(x, y).y());
  options.rectangle = corners;
  options.size = "4,3";
  options.orientation = folder_ / "model";
  ASSERT_TRUE(rectified(options, "out.png"));
  EXPECT_NEAR(json().at("photographs")[0].at("centre_over_plane_m")[2].get<double>(), 6, 1e-3);
  EXPECT_TRUE(is_there(folder_ / "out.pgw"));
  EXPECT_EQ(json().at("redundancy"), 0);
}

TEST_F(RectifyPlane, WhatCannotBeIsStatedInWords) {
  put_points(8);
  const std::string points = folder_ / "points.csv";
  const auto why = [&](const RectifyOptions& options, const char* out = "out.tif") {
    const auto done = rectified(options, out);
    return done ? std::string("done") : done.error().message;
  };
  EXPECT_NE(why({}).find("points of it"), std::string::npos);
  EXPECT_NE(why({.points = points}, "out.jpg").find(".png"), std::string::npos);
  EXPECT_NE(why({.points = points, .control = "a,b,c"}).find("for a project"), std::string::npos);
  EXPECT_NE(why({.rectangle = "1,2,3,4,5,6,7,8"}).find("size"), std::string::npos);
  EXPECT_NE(why({.rectangle = "1,2,3", .size = "4,3"}).find("four corners"), std::string::npos);
  EXPECT_NE(why({.rectangle = "1,2,x,4,5,6,7,8", .size = "4,3"}).find("no number"), std::string::npos);
  EXPECT_NE(why({.rectangle = "1,1,2,2,3,3,4,4", .size = "4,3"}).find("line"), std::string::npos);
  EXPECT_NE(why({.rectangle = "100,100,500,100,100,400,500,400", .size = "4,3"}).find("exchanged"), std::string::npos);
  EXPECT_NE(why({.points = points, .extent = "900,900,901,901"}).find("no photograph shows"), std::string::npos);
  EXPECT_NE(why({.points = points, .extent = "1,1,0,0"}).find("left,bottom"), std::string::npos);
  EXPECT_NE(why({.points = points, .cell_m = 1e-6}).find("too many cells"), std::string::npos);
  ASSERT_TRUE(write_file(folder_ / "bad.csv", "a,1,2,3\n"));
  EXPECT_NE(why({.points = folder_ / "bad.csv"}).find("line 1"), std::string::npos);
  const auto missing = rectify_plane(folder_ / "none.jpg", folder_ / "out.tif", {.points = points}, collinea::Run{});
  ASSERT_FALSE(missing);
  const auto no_project = rectify_plane(folder_ / "model", folder_ / "out.tif", {.region = "0,0,1,1"}, collinea::Run{});
  ASSERT_FALSE(no_project);
}

}  // namespace
}  // namespace collinea
