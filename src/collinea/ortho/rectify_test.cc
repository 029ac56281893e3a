// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/rectify.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// What is painted on the wall, smooth enough for pixels of 1 cm.
float painted(const Vector2d& position, int channel) {
  return float(128 + 100 * std::sin(2.1 * position.x() + channel) * std::cos(1.7 * position.y()));
}

struct Shot {
  PlaneView view;
  ColourImage image;
};

// An image of the wall by a distorting camera that stands at `centre` of the plane's frame.
Shot shoot(std::uint32_t id, const Vector3d& centre, const Vector3d& target) {
  Camera camera = ideal_camera(500, 600, 400);
  camera.params[Camera::kK1] = -0.06;
  camera.params[Camera::kCx] += 5;
  const Vector3d forward = (target - centre).normalized(), right = forward.cross(Vector3d::UnitY()).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  Shot shot{{ImageId{id}, camera, {}, centre}, ColourImage(600, 400, 3)};
  shot.view.cam_from_plane << rotation.leftCols<2>(), -(rotation * centre);
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 600; ++x) {
      const Vector3d ray = rotation.transpose() * ray_in_cam(camera, {x + 0.5, y + 0.5});
      const Vector3d at = centre - ray * (centre.z() / ray.z());
      for (int c = 0; c < 3; ++c) shot.image.at(x, y, c) = std::uint8_t(std::lround(painted(at.head<2>(), c)));
    }
  return shot;
}

TEST(WriteRectified, EveryCellHasTheColourOfItsPosition) {
  const TestFolder folder;
  const std::vector<Shot> shots = {shoot(0, {2, 1, 5}, {2.5, 1.5, 0}), shoot(1, {7, 2, 4}, {6, 2, 0})};
  const std::vector<PlaneView> views = {shots[0].view, shots[1].view};
  const PixelSource pixels = [&](ImageId image, int shrink) -> Result<ColourImage> {
    EXPECT_EQ(shrink, 1);
    return shots[image.value].image;
  };
  const auto grid = plane_grid({{-2, -1}, {10, 4}}, 0.01);
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->width, 1200);
  EXPECT_EQ(grid->height, 500);
  collinea::Run run;
  const auto summary = write_rectified(folder / "a.png", *grid, views, pixels, run);
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_EQ(summary->painted_cells + summary->empty_cells, 600'000u);
  EXPECT_EQ(summary->cells_of[0] + summary->cells_of[1], summary->painted_cells);
  EXPECT_GT(summary->cells_of[1], 50'000u);
  const auto tiff = GeoTiffReader::open([&] {
    run.threads = 3;
    EXPECT_TRUE(write_rectified(folder / "a.tif", *grid, views, pixels, run));
    EXPECT_TRUE(write_rectified(folder / "b.tif", *grid, views, pixels, collinea::Run{}));
    return folder / "a.tif";
  }());
  EXPECT_TRUE(*read_file(folder / "a.tif") == *read_file(folder / "b.tif"));  // on one thread and on three
  ASSERT_TRUE(tiff) << tiff.error().message;
  EXPECT_NEAR(tiff->grid().west_m, -2, 1e-9);
  EXPECT_NEAR(tiff->grid().north_m, 4, 1e-9);
  const auto rgba = tiff->read_byte(0, 0, 1200, 500);
  ASSERT_TRUE(rgba);
  std::uint64_t seen = 0;
  double squares = 0;
  for (int y = 0; y < 500; ++y)
    for (int x = 0; x < 1200; ++x) {
      const Vector2d position(grid->east_of(x + 0.5), grid->north_of(y + 0.5));
      const bool shown = pixel_of(views[0], position) || pixel_of(views[1], position);
      ASSERT_EQ(rgba->at(x, y, 3), shown ? 255 : 0);
      if (!shown) continue;
      ++seen;
      for (int c = 0; c < 3; ++c) squares += std::pow(double(rgba->at(x, y, c)) - double(painted(position, c)), 2);
    }
  EXPECT_EQ(seen, summary->painted_cells);
  EXPECT_LT(std::sqrt(squares / double(3 * seen)), 0.6);  // twice rounded: 0.29 each
  const auto world = read_file(folder / "a.pgw");
  ASSERT_TRUE(world);
  EXPECT_EQ(*world, "0.01\n0\n0\n-0.01\n-1.995\n3.995\n");
  const auto png = read_colour(folder / "a.png");
  ASSERT_TRUE(png);
  EXPECT_EQ(png->at(600, 250, 1), rgba->at(600, 250, 1));
}

TEST(ViewsFor, TheBestComesFirstAndOthersFillWhatItDoesNotShow) {
  const PlaneView slanted = shoot(0, {12, 1.5, 3}, {4, 1.5, 0}).view, frontal = shoot(1, {4, 1.5, 5}, {4, 1.5, 0}).view,
                  far = shoot(2, {4, 1.5, 40}, {4, 1.5, 0}).view, elsewhere = shoot(3, {90, 1, 5}, {90, 1, 0}).view;
  const std::vector<PlaneView> views = {slanted, far, elsewhere, frontal};
  const auto one = views_for(views, {{3, 0}, {5, 3}});
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].image.value, 1u);
  const auto more = views_for(views, {{-4, 0}, {12, 3}});
  ASSERT_GE(more.size(), 2u);
  EXPECT_EQ(more[0].image.value, 1u);
  EXPECT_TRUE(views_for(views, {{500, 0}, {510, 3}}).empty());
}

TEST(PlaneGrid, SenselessSizesAreRefused) {
  EXPECT_FALSE(plane_grid({{0, 0}, {0, 1}}, 0.1));
  EXPECT_FALSE(plane_grid({{0, 0}, {1, 1}}, 1e-9));
  EXPECT_FALSE(plane_grid({{0, 0}, {std::nan(""), 1}}, 0.1));
}

}  // namespace
}  // namespace collinea
