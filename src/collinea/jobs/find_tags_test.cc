// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/find_tags.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/feature/test_tags.h"
#include "collinea/io/control_file.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

GreyImage bytes_of(const FloatImage& image) {
  GreyImage out(image.width, image.height);
  for (std::size_t i = 0; i < out.data.size(); ++i)
    out.data[i] = std::uint8_t(std::lround(std::clamp(image.data[i], 0.f, 255.f)));
  return out;
}

// Two images: tags 12 and 7 in both, 30 in the second alone and 5 twice in the first.
class FindTags : public ::testing::Test {
 protected:
  void SetUp() override {
    draw("a b.png", {{12, {50, 50}}, {7, {150.3, 52}}, {5, {50, 150}}, {5, {150, 150}}});
    draw("c.png", {{12, {52.6, 48.2}}, {7, {150, 50}}, {30, {50, 150}}, {5, {150, 150}}});
  }
  void draw(const char* name, const std::vector<std::pair<int, Vector2d>>& tags) {
    FloatImage image(200, 200, 1, 0.5f);
    for (const auto& [id, at] : tags)
      draw_tag(image, {.family = TagFamily::kAruco4x4x50, .id = id, .at = at, .side_px = 36, .rotation_rad = 0.3});
    for (float& grey : image.data) grey = 40 + 160 * grey;
    images_.push_back(folder_ / name);
    ASSERT_TRUE(write_png(images_.back(), bytes_of(with_noise(image, 2, tags.size()))));
  }
  [[nodiscard]] Result<TagsReport> find(const FindTagsOptions& options) const {
    return find_tags_in_files(images_, folder_ / "marks.csv", options, {});
  }
  TestFolder folder_;
  std::vector<std::filesystem::path> images_;
};

TEST_F(FindTags, AreMarksOfPointsOfTheirNumbers) {
  const auto report = find({});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->tags.size(), 8u);
  const auto control = read_control(folder_ / "marks.csv");
  ASSERT_TRUE(control) << control.error().message;
  ASSERT_EQ(control->observations.size(), 4u);  // 12 and 7; 5 is seen once in one image alone
  for (const ControlFileObservation& seen : control->observations) {
    EXPECT_TRUE(seen.point == "12" || seen.point == "7") << seen.point;
    if (seen.point == "12" && seen.file == "c.png") {
      EXPECT_LT((seen.pixel - Vector2d(52.6, 48.2)).norm(), 0.03);
    }
    EXPECT_TRUE(seen.sigma_px > 0 && seen.sigma_px < 0.05);
  }
  EXPECT_NE(tags_text(*report).find("4 of them marks"), std::string::npos);
}

TEST_F(FindTags, HaveTheNamesOfControlPoints) {
  ASSERT_TRUE(
      write_file(folder_ / "control.csv",
                 "# collinea control, EPSG:32633\npoint, T30, 1, 2, 3\npoint, 12, 4, 5, 6\npoint, B12, 7, 8, 9\n"
                 "point, A7, 1, 1, 1\npoint, B7, 2, 2, 2\n"));
  const auto report = find({.control = folder_ / "control.csv", .as = MarksAs::kEdits});
  ASSERT_TRUE(report) << report.error().message;
  const auto text = read_file(folder_ / "marks.csv");
  ASSERT_TRUE(text);
  EXPECT_NE(text->find("mark T30 c.png "), std::string::npos) << *text;
  EXPECT_NE(text->find("mark 12 \"a b.png\" "), std::string::npos) << *text;
  EXPECT_EQ(std::count(text->begin(), text->end(), '\n'), 3) << *text;  // two names end in 7
}

TEST_F(FindTags, WhatIsWrongIsRefused) {
  EXPECT_FALSE(find_tags_in_files({}, folder_ / "marks.csv", {}, {}));
  EXPECT_FALSE(find({.control = folder_ / "nothing.csv"}));
  images_.push_back(folder_ / "nothing.png");
  EXPECT_FALSE(find({}));
}

}  // namespace
}  // namespace collinea
