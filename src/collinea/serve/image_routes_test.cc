// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/image_routes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "collinea/feature/test_tags.h"
#include "collinea/raster/image_file.h"
#include "collinea/serve/test_server.h"

namespace collinea {
namespace {

using testing::Answer;

/// A server of one project with one photograph.
class ImageRoutesTest : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    std::filesystem::create_directories(folder_ / "photos");
    ASSERT_TRUE(write_jpeg(folder_ / "photos" / "a.jpg", Raster<std::uint8_t>(1000, 700, 3, 90), 90));
    Settings settings;
    settings.photos = (folder_ / "photos").string();
    ASSERT_TRUE(write_settings(folder_ / "village", settings));
    Block block;
    block.cameras[CameraId{1}] = ideal_camera(1000, 1000, 700);
    block.images[ImageId{3}] = {.file = "a.jpg", .camera = CameraId{1}};
    block.images[ImageId{4}] = {.file = "missing.jpg", .camera = CameraId{1}};
    auto store = ProjectStore::open(folder_ / "village");
    ASSERT_TRUE(store) << store.error().message;
    ASSERT_TRUE(store->write_setup(block));
  }
};

TEST_F(ImageRoutesTest, TilesComeWithATag) {
  const std::string images = project() + "/images";
  const Answer tile = fetch(images + "/3/tiles/0/0/0.jpg");
  ASSERT_EQ(tile.status, 200) << tile.body;
  EXPECT_EQ(tile.header("Content-Type"), "image/jpeg");
  EXPECT_TRUE(tile.body.starts_with("\xff\xd8"));
  EXPECT_NE(tile.header("Cache-Control").find("max-age"), std::string::npos);
  EXPECT_EQ(fetch(images + "/3/tiles/2/3/2.jpg").status, 200);
  const Answer same = fetch(images + "/3/tiles/0/0/0.jpg", "If-None-Match: " + tile.header("ETag") + "\r\n");
  EXPECT_EQ(same.status, 304);
  EXPECT_TRUE(same.body.empty());
}

TEST_F(ImageRoutesTest, NoOtherTilesAreThere) {
  const std::string images = project() + "/images";
  for (const char* path :
       {"/3/tiles/3/0/0.jpg", "/3/tiles/0/1/0.jpg", "/3/tiles/2/4/0.jpg", "/3/tiles/-1/0/0.jpg", "/3/tiles/0/0/0.png",
        "/3/tiles/0/0/.jpg", "/3/tiles/0/0/0.jpg/x", "/3/tiles/0/0", "/3/tiles",
        "/3/tiles/99999999999999999999/0/0.jpg", "/3/tiles/4294967296/0/0.jpg", "/5/tiles/0/0/0.jpg",
        "/4294967299/tiles/0/0/0.jpg", "/4/tiles/0/0/0.jpg", "/3/tiles/..%2f..%2f/0/0.jpg"})
    EXPECT_EQ(fetch(images + path).status, 404) << path;
  EXPECT_EQ(post(images + "/3/tiles/0/0/0.jpg", "{}").status, 405);
}

TEST_F(ImageRoutesTest, ABrokenPhotographIsNamed) {
  ASSERT_TRUE(write_file(folder_ / "photos" / "a.jpg", "no photograph"));
  const Answer broken = fetch(project() + "/images/3/tiles/0/0/0.jpg");
  EXPECT_EQ(broken.status, 422);
  EXPECT_NE(broken.body.find("a.jpg"), std::string::npos) << broken.body;
}

// Tags 12 and 7, and 5 twice.
TEST_F(ImageRoutesTest, CodedTagsAreFound) {
  FloatImage drawn(1000, 700, 1, 0.5f);
  const std::pair<int, Eigen::Vector2d> tags[] = {
      {12, {100.3, 80.6}}, {7, {400, 300}}, {5, {700, 200}}, {5, {200, 500}}};
  for (const auto& [id, at] : tags)
    draw_tag(drawn, {.family = TagFamily::kAruco4x4x50, .id = id, .at = at, .side_px = 40, .rotation_rad = 0.2});
  GreyImage grey(1000, 700);
  for (std::size_t i = 0; i < grey.data.size(); ++i)
    grey.data[i] = std::uint8_t(std::lround(std::clamp(40 + 160 * drawn.data[i], 0.f, 255.f)));
  ASSERT_TRUE(write_jpeg(folder_ / "photos" / "a.jpg", grey, 95));
  const Answer answer = fetch(project() + "/images/3/tags");
  ASSERT_EQ(answer.status, 200) << answer.body;
  const auto found = nlohmann::json::parse(answer.body).at("tags");
  ASSERT_EQ(found.size(), 2u) << answer.body;
  for (const auto& tag : found) {
    const bool is_first = tag.at("number") == 12;
    EXPECT_TRUE(is_first || tag.at("number") == 7);
    const Eigen::Vector2d at(tag.at("pixel").at(0).get<double>(), tag.at("pixel").at(1).get<double>());
    EXPECT_LT((at - tags[is_first ? 0 : 1].second).norm(), 0.1);
    EXPECT_LT(tag.at("sigma_px").get<double>(), 0.1);
  }
  EXPECT_EQ(fetch(project() + "/images/4/tags").status, 404);
  EXPECT_EQ(fetch(project() + "/images/5/tags").status, 404);
  EXPECT_EQ(post(project() + "/images/3/tags", "{}").status, 405);
}

// Nothing is written outside of the project.
TEST_F(ImageRoutesTest, ACacheThatLeadsElsewhereIsRefused) {
  std::filesystem::create_directories(folder_ / "elsewhere");
  std::filesystem::create_symlink(folder_ / "elsewhere", folder_ / "village" / "cache");
  EXPECT_EQ(fetch(project() + "/images/3/tiles/0/0/0.jpg").status, 422);
  EXPECT_TRUE(std::filesystem::is_empty(folder_ / "elsewhere"));
}

}  // namespace
}  // namespace collinea
