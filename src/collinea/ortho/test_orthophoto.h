// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "collinea/ortho/orthophoto.h"

// A made-up world and orthophotos of it, for tests.
namespace collinea {

using Colour = std::array<double, 3>;

// A world to image: level ground at height 0 with a soft pattern and one box with a red roof and blue walls.
struct World {
  double box_from = 12, box_to = 20, box_height_m = 8;  // in x and in y [m]

  [[nodiscard]] bool on_box(double x, double y) const {
    return x > box_from && x < box_to && y > box_from && y < box_to;
  }
  [[nodiscard]] static Colour ground(double x, double y) {
    return {90 + 20 * std::sin(0.3 * x), 120 + 25 * std::sin(0.25 * y), 100 + 15 * std::sin(0.2 * (x + y))};
  }
  [[nodiscard]] static Colour roof() { return {200, 40, 40}; }
  [[nodiscard]] Colour colour(double x, double y) const { return on_box(x, y) ? roof() : ground(x, y); }

  // What a ray from above meets first.
  [[nodiscard]] Colour seen(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d roof_point = from + ray * ((box_height_m - from.z()) / ray.z());
    if (on_box(roof_point.x(), roof_point.y())) return roof();
    const Eigen::Vector3d ground_point = from - ray * (from.z() / ray.z());
    // Between roof and ground height the ray passes over the box's footprint: it meets a wall.
    for (int i = 0; i <= 60; ++i) {
      const Eigen::Vector3d p = roof_point + (ground_point - roof_point) * (i / 60.0);
      if (on_box(p.x(), p.y())) return {30, 30, 160};
    }
    return ground(ground_point.x(), ground_point.y());
  }
};

inline Camera lens() {
  Camera camera = ideal_camera(250, 240, 200);
  camera.params[Camera::kK1] = -0.04;
  camera.params[Camera::kP1] = 0.002;
  camera.params[Camera::kCx] += 3;
  return camera;
}

inline Rigid3 looking_down_from(const Eigen::Vector3d& centre, double heading_rad) {
  const Eigen::Quaterniond down(Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond rotation = Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()) * down *
                                      Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitY());
  return {rotation, -(rotation * centre)};
}

inline Block block_of(const std::vector<Eigen::Vector3d>& centres) {
  Block block;
  block.cameras[CameraId{1}] = lens();
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const ImageId id{std::uint32_t(10 + i)};
    block.images[id] = Image{.file = {}, .camera = CameraId{1}, .taken = {}, .position = {}, .attitude = {}};
    set_pose(block, id, looking_down_from(centres[i], 0.4 * double(i)));
  }
  return block;
}

// What was planted: each channel has exposures of its own.
inline std::array<double, 3> gain_of(ImageId image) {
  std::array<double, 3> gain;
  for (std::uint32_t c = 0; c < 3; ++c) gain[c] = 1 + 0.06 * (double((image.value + 2 * c) % 5) - 2);
  return gain;
}

inline ColourImage raster(const World& world, const Block& block, ImageId image, bool uneven) {
  const Camera& camera = block.camera_of(image);
  const Rigid3 world_from_cam = inverse(pose_of(block, image));
  const std::array<double, 3> gain = gain_of(image);
  ColourImage pixels(camera.width_px, camera.height_px, 3);
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const Eigen::Vector2d pixel(x + 0.5, y + 0.5);
      const Colour colour = world.seen(world_from_cam.translation, world_from_cam.rotation * ray_in_cam(camera, pixel));
      const double darker = std::exp(-0.25 * relative_radius2(camera, pixel));
      for (std::size_t c = 0; c < 3; ++c) {
        const double factor = uneven ? gain[c] * darker : 1;
        pixels.at(x, y, int(c)) = std::uint8_t(std::lround(std::min(255.0, factor * colour[c])));
      }
    }
  }
  return pixels;
}

inline ColourImage shrunk(const ColourImage& image, int shrink) {
  ColourImage small((image.width + shrink - 1) / shrink, (image.height + shrink - 1) / shrink, 3);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        int sum = 0, count = 0;
        for (int v = y * shrink; v < std::min(image.height, (y + 1) * shrink); ++v)
          for (int u = x * shrink; u < std::min(image.width, (x + 1) * shrink); ++u) sum += image.at(u, v, c), ++count;
        small.at(x, y, c) = std::uint8_t((sum + count / 2) / count);
      }
    }
  }
  return small;
}

inline constexpr double kCell = 0.2;
inline constexpr int kSide = 160;  // cells: 32 m

inline HeightField surface_of(const World& world) {
  HeightField field;
  field.grid = {0, kSide * kCell, kCell, kSide, kSide, ""};
  field.read = [grid = field.grid, world](int column, int row, int width, int height) -> Result<FloatImage> {
    EXPECT_TRUE(column >= 0 && row >= 0 && column + width <= kSide && row + height <= kSide);
    FloatImage heights(width, height);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        heights.at(x, y) =
            world.on_box(grid.east_of(column + x + 0.5), grid.north_of(row + y + 0.5)) ? float(world.box_height_m) : 0;
    if (column == 0 && row == 0) heights.at(3, 4) = std::numeric_limits<float>::quiet_NaN();
    return heights;
  };
  return field;
}

struct Product {
  MapGrid grid;
  Raster<std::uint8_t> rgba;
  Raster<std::uint16_t> source;
  Result<OrthoSummary> summary;
};

inline Product make(const World& world, const Block& block, OrthoOptions options, bool uneven = false, int threads = 1,
                    const SeamGuides& guides = {}) {
  std::map<ImageId, ColourImage> images;
  for (const auto& [id, image] : block.images) images[id] = raster(world, block, id, uneven);
  const PixelSource pixels = [&](ImageId image, int shrink) -> Result<ColourImage> {
    return shrunk(images.at(image), shrink);
  };
  Product product;
  const OrthoSink sink{[&](const MapGrid& grid) -> Result<> {
                         product.grid = grid;
                         product.rgba = Raster<std::uint8_t>(grid.width, grid.height, 4);
                         product.source = Raster<std::uint16_t>(grid.width, grid.height);
                         return {};
                       },
                       [&](int column, int row, const OrthoTile& tile) -> Result<> {
                         for (int y = 0; y < tile.rgba.height; ++y) {
                           std::copy_n(tile.rgba.row(y), 4 * tile.rgba.width, product.rgba.row(row + y) + 4 * column);
                           std::copy_n(tile.source.row(y), tile.source.width, product.source.row(row + y) + column);
                         }
                         return {};
                       }};
  Run run;
  run.threads = threads;
  product.summary = make_orthophoto(block, nullptr, surface_of(world), guides, pixels, kCell, sink, options, run);
  return product;
}

inline std::vector<Eigen::Vector3d> nine_centres() {
  std::vector<Eigen::Vector3d> centres;
  for (int i = 0; i < 9; ++i) centres.emplace_back(4 + 12 * (i % 3), 4 + 12 * (i / 3), 50);
  return centres;
}

}  // namespace collinea
