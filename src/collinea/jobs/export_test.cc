// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/export.h"

#include <gtest/gtest.h>

#include "collinea/base/test_folder.h"
#include "collinea/cloud/ply.h"

namespace collinea {
namespace {

TEST(Export, ATiePointOfVeryManyImagesHasTheLargestNumberThereIs) {
  const TestFolder folder;
  Block block;
  block.cameras[CameraId{0}] = ideal_camera(1000, 1000, 800);
  block.points[PointId{0}].position_in_world = {0, 0, 10};
  for (std::uint32_t i = 0; i < 300; ++i) {
    block.images[ImageId{i}] = {.file = std::to_string(i) + ".jpg", .camera = CameraId{0}};
    set_pose(block, ImageId{i}, {});
    block.observations.push_back({.image = ImageId{i}, .point = PointId{0}, .pixel = {500, 400}});
  }
  Settings settings;
  settings.photos = (folder / "").string();
  auto project = create_project(folder / "project", settings, {});
  ASSERT_TRUE(project) << project.error().message;
  ASSERT_TRUE(project->store.write_setup(block));
  ASSERT_TRUE(project->store.write_orientation(block));
  ASSERT_TRUE(export_block(*project, folder / "out", {.format = ExportFormat::kPly}));
  const auto cloud = read_ply(folder / "out/tie_points.ply");
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->size(), 1u);
  EXPECT_EQ(cloud->front().images, 255);
}

}  // namespace
}  // namespace collinea
