// SPDX-License-Identifier: Apache-2.0
#pragma once

// A project with exact poses over a known roof, for tests of plotting.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "collinea/base/test_folder.h"
#include "collinea/block/world_frame.h"
#include "collinea/project/settings.h"
#include "collinea/raster/geotiff.h"
#include "collinea/store/project_store.h"

namespace collinea::testing {

/// Four vertical images over flat ground, measured exactly, with 2 cm and 0.2 mrad for each pose.
inline Block plot_block() {
  Block block;
  block.georeference = {"EPSG:32633", 48.2, 15.63, 300};
  block.cameras[CameraId{0}] = ideal_camera(1000, 1000, 800);
  const Eigen::Quaterniond down(0, 1, 0, 0);  // x east, y south, z down
  for (std::uint32_t i = 0; i < 4; ++i) {
    block.images[ImageId{i}] = {.file = "IMG_" + std::to_string(i) + ".jpg", .camera = CameraId{0}};
    const Eigen::Vector3d centre(15.0 * i, 3.0 * (i % 2), 60);
    set_pose(block, ImageId{i}, {down, -(down * centre)});
  }
  for (std::uint32_t k = 0; k < 60; ++k) {
    const Eigen::Vector3d point(-20 + 10.0 * (k % 10), -15 + 6.0 * (k / 10), (k % 7) - 3.0);
    block.points[PointId{k}].position_in_world = point;
    for (std::uint32_t i = 0; i < 4; ++i)
      if (const auto pixel = project(block.camera_of(ImageId{i}), pose_of(block, ImageId{i}) * point);
          pixel && inside(block.camera_of(ImageId{i}), *pixel))
        block.observations.push_back({ImageId{i}, PointId{k}, 0, *pixel, 0.5});
  }
  return block;
}

class PlotProjectTest : public ::testing::Test {
 protected:
  static constexpr double kCell_m = 0.25;

  void SetUp() override {
    std::filesystem::create_directories(project() / "products");
    ASSERT_TRUE(write_settings(project(), {}));
    auto store = ProjectStore::open(project());
    ASSERT_TRUE(store) << store.error().message;
    ASSERT_TRUE(store->write_setup(block_));
    BlockCovariances covariances;
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << 2e-4, 2e-4, 2e-4, 0.02, 0.02, 0.02;
    for (const auto& [id, image] : block_.images) covariances.poses[id] = sigma.cwiseAbs2().asDiagonal();
    covariances.points.assign(block_.points.size(), 1e-4 * Eigen::Matrix3d::Identity());
    ASSERT_TRUE(store->write_orientation(block_));
    ASSERT_TRUE(store->write_adjustment(block_, covariances));
    write_surface();
  }
  [[nodiscard]] std::filesystem::path project() const { return folder_ / "village"; }

  /// A level roof in the map, 10 m by 8 m, 5 m over the origin.
  [[nodiscard]] std::vector<Eigen::Vector3d> roof() const {
    const Eigen::Vector3d corner = frame_.map_from_local(Eigen::Vector3d(18, -3, 5));
    return {corner, corner + Eigen::Vector3d(10, 0, 0), corner + Eigen::Vector3d(10, 8, 0),
            corner + Eigen::Vector3d(0, 8, 0)};
  }
  [[nodiscard]] Eigen::Vector2d pixel(std::uint32_t image, const Eigen::Vector3d& on_map) const {
    return *collinea::project(block_.camera_of(ImageId{image}),
                              pose_of(block_, ImageId{image}) * frame_.local_from_map(on_map));
  }

  TestFolder folder_;
  Block block_ = plot_block();
  LocalFrame frame_ = *world_frame(*block_.georeference);

 private:
  // The plane of the roof, wherever there are heights.
  void write_surface() const {
    const Eigen::Vector3d corner = roof()[0];
    const MapGrid grid{corner.x() - 20, corner.y() + 30, kCell_m, 200, 200, frame_.wkt1()};
    for (const auto& [name, value] : {std::pair("dsm.tif", corner.z()), std::pair("dsm_sigma.tif", 0.06),
                                      std::pair("dsm_sigma_relative.tif", 0.03)}) {
      auto writer = GeoTiffWriter<float>::create(project() / "products" / name, grid, 1, {.nodata = -9999});
      ASSERT_TRUE(writer);
      ASSERT_TRUE(writer->write(0, 0, FloatImage(grid.width, grid.height, 1, float(value))));
      ASSERT_TRUE(writer->finish());
    }
  }
};

}  // namespace collinea::testing
