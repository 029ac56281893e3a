// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/seamlines_file.h"

#include <gtest/gtest.h>

#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

Block three_images() {
  Block block;
  block.cameras[CameraId{1}] = ideal_camera(250, 240, 200);
  for (std::uint32_t i = 1; i <= 3; ++i) {
    block.images[ImageId{i}] = Image{.file = "flight/IMG_" + std::to_string(i) + ".jpg",
                                     .camera = CameraId{1},
                                     .taken = {},
                                     .position = {},
                                     .attitude = {}};
    if (i != 2) set_pose(block, ImageId{i}, Rigid3{});
  }
  return block;
}

const std::vector<ImageId> kSources = {ImageId{1}, ImageId{3}};
const std::vector<SeamPolygon> kSeamlines = {{2, {{{0.5, 0}, {0.5, 10}, {10, 10}, {10, 0}}, {{2, 2}, {3, 2}, {3, 3}}}},
                                             {1, {{{10, 0}, {10, 10}, {20, 10}}}}};

TEST(SeamlinesFile, ComesBackAsItWasWritten) {
  const TestFolder folder;
  const Block block = three_images();
  ASSERT_TRUE(write_seamlines(folder / "s.gpkg", kSeamlines, block, kSources, ""));
  const auto read = read_seamlines(folder / "s.gpkg", block, kSources, "");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), kSeamlines.size());
  for (std::size_t i = 0; i < kSeamlines.size(); ++i) {
    EXPECT_EQ(read->at(i).source, kSeamlines[i].source);
    EXPECT_EQ(read->at(i).rings, kSeamlines[i].rings);
  }
}

TEST(SeamlinesFile, ImagesThatCannotBeUsedAreNamed) {
  const TestFolder folder;
  Block block = three_images();
  ASSERT_TRUE(write_seamlines(folder / "s.gpkg", kSeamlines, block, kSources, ""));
  const auto complaint = [&] {
    const auto read = read_seamlines(folder / "s.gpkg", block, std::vector<ImageId>{ImageId{1}}, "");
    return read ? std::string("none") : read.error().message;
  };
  EXPECT_NE(complaint().find("feature 1: flight/IMG_3.jpg is not oriented"), std::string::npos) << complaint();
  block.images.erase(ImageId{3});
  EXPECT_NE(complaint().find("feature 1: flight/IMG_3.jpg is no photograph of the project"), std::string::npos)
      << complaint();
}

}  // namespace
}  // namespace collinea
