// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/depth_folder.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

TEST(DepthFolder, AStaleMapThatCannotBeRemovedIsAnError) {
  const TestFolder folder;
  const Block block;
  const WorkingImages images(block, {}, {});
  ASSERT_TRUE(DepthFolder::open(folder / "depth", "before", block, images));
  const auto stale = folder / "depth/000000_a.jpg.depth.tif";
  std::filesystem::create_directories(stale / "not empty");
  for (int attempt = 0; attempt < 2; ++attempt) {
    const auto opened = DepthFolder::open(folder / "depth", "after", block, images);
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, Errc::kBadInput);
    EXPECT_NE(opened.error().message.find(stale.string()), std::string::npos) << opened.error().message;
  }
}

}  // namespace
}  // namespace collinea
