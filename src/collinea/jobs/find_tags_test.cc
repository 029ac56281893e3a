// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/find_tags.h"

#include <gtest/gtest.h>

#include <mutex>
#include <set>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/edit/edit.h"
#include "collinea/feature/test_tags.h"
#include "collinea/io/control_file.h"
#include "collinea/io/text.h"
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

constexpr TagFamily kFamily = TagFamily::kAruco4x4x50, kOther = TagFamily::kAruco6x6x50;

struct Drawn {
  int id;
  Vector2d at;
  TagFamily family = kFamily;
};

// Two images: tags 12 and 7 in both, 30 in the second alone and 5 twice in the first.
class FindTags : public ::testing::Test {
 protected:
  void SetUp() override {
    draw("a b.png", {{12, {50, 50}}, {7, {150.3, 52}}, {5, {50, 150}}, {5, {150, 150}}});
    draw("c.png", {{12, {52.6, 48.2}}, {7, {150, 50}}, {30, {50, 150}}, {5, {150, 150}}});
  }
  void draw(const std::string& name, const std::vector<Drawn>& tags) {
    FloatImage image(200, 200, 1, 0.5f);
    for (const Drawn& one : tags)
      draw_tag(image, {.family = one.family, .id = one.id, .at = one.at, .side_px = 36, .rotation_rad = 0.3});
    for (float& grey : image.data) grey = 40 + 160 * grey;
    images_.push_back(folder_ / name);
    ASSERT_TRUE(write_png(images_.back(), bytes_of(with_noise(image, 2, tags.size()))));
  }
  void write_control(const std::string& points) const {
    ASSERT_TRUE(write_file(folder_ / "control.csv", "# collinea control, EPSG:32633\n" + points));
  }
  [[nodiscard]] Result<TagsReport> find(const FindTagsOptions& options = {}, int threads = 1) const {
    return find_tags_in_files(images_, folder_ / "marks.csv", options, {.threads = threads});
  }
  [[nodiscard]] std::multiset<std::string> points_found(const FindTagsOptions& options = {}) const {
    std::multiset<std::string> points;
    const auto report = find(options);
    EXPECT_TRUE(report) << report.error().message;
    if (report)
      for (const NamedTag& one : report->tags)
        if (!one.point.empty()) points.insert(one.point);
    return points;
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

// A single reading of a tag of another family, as if something had been misread.
TEST_F(FindTags, OneReadingDoesNotChangeNamesOfOthers) {
  draw("d.png", {{12, {50, 50}, kOther}, {7, {150, 150}}});
  const std::multiset<std::string> expected{"12", "12", "7", "7", "7"};
  EXPECT_EQ(points_found(), expected);
  write_control("point, 12, 4, 5, 6\npoint, B7, 7, 8, 9\n");
  EXPECT_EQ(points_found({.control = folder_ / "control.csv"}),
            (std::multiset<std::string>{"12", "12", "B7", "B7", "B7"}));
}

TEST_F(FindTags, TagsOfTwoFamiliesWithOneNumberAreToldApart) {
  for (const char* name : {"d.png", "e.png"}) draw(name, {{12, {50, 50}, kOther}});
  EXPECT_EQ(points_found(), (std::multiset<std::string>{"7", "7", "aruco-4x4-250-12", "aruco-4x4-250-12",
                                                        "aruco-6x6-250-12", "aruco-6x6-250-12"}));
  write_control("point, 12, 4, 5, 6\n");
  EXPECT_EQ(points_found({.control = folder_ / "control.csv"}), std::multiset<std::string>{});
}

TEST_F(FindTags, EditsAreReadAsTheyWereMeant) {
  draw("say \"x\", #1.png", {{12, {50, 50}}});
  write_control("point, # \"12, 4, 5, 6\n");
  ASSERT_TRUE(find({.control = folder_ / "control.csv", .as = MarksAs::kEdits}));
  const auto text = read_file(folder_ / "marks.csv");
  ASSERT_TRUE(text);
  std::set<std::string> images;
  for (const std::string_view line : lines_of(*text)) {
    if (line.empty()) continue;
    const auto words = words_in_line(line);
    ASSERT_TRUE(words) << line;
    const auto edit = parse_edit(*words);
    ASSERT_TRUE(edit) << line;
    const auto& mark = std::get<MarkPoint>(*edit);
    EXPECT_EQ(mark.point, "# \"12");
    EXPECT_LT((mark.pixel - Vector2d(50, 50)).norm(), 4);
    images.insert(mark.image);
  }
  EXPECT_EQ(images, (std::set<std::string>{"a b.png", "c.png", "say \"x\", #1.png"}));
}

TEST_F(FindTags, NamesThatRowsCannotHoldAreRefused) {
  draw("1,2.png", {{12, {50, 50}}});
  auto refused = find();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("1,2.png"), std::string::npos) << refused.error().message;
  EXPECT_TRUE(find({.as = MarksAs::kEdits}));
  images_.pop_back();
  ASSERT_TRUE(write_file(folder_ / "control.csv", "# collinea control\npoint; a,12; 1; 2; 3\n"));
  refused = find({.control = folder_ / "control.csv"});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("a,12"), std::string::npos) << refused.error().message;
  EXPECT_TRUE(find({.control = folder_ / "control.csv", .as = MarksAs::kEdits}));
}

TEST_F(FindTags, ImagesOfOneFileNameAreRefused) {
  std::filesystem::create_directory(folder_ / "more");
  draw("more/c.png", {{12, {50, 50}}});
  const auto refused = find();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("same name"), std::string::npos) << refused.error().message;
}

TEST_F(FindTags, WhatIsReadIsNotWrittenOver) {
  write_control("point, 12, 4, 5, 6\n");
  for (const auto& out : {folder_ / "control.csv", folder_ / "nothing" / ".." / "control.csv", images_[1]}) {
    std::filesystem::create_directory(folder_ / "nothing");
    const auto before = read_file(out);
    const auto refused = find_tags_in_files(images_, out, {.control = folder_ / "control.csv"}, {});
    ASSERT_FALSE(refused) << out;
    EXPECT_NE(refused.error().message.find("written over"), std::string::npos) << refused.error().message;
    EXPECT_EQ(*read_file(out), *before);
  }
}

TEST_F(FindTags, ThreadsDoNotChangeTheResult) {
  for (int i = 0; i < 5; ++i) draw("more" + std::to_string(i) + ".png", {{12, {50, 50.0 + i}}, {i, {150, 140}}});
  const auto one = find();
  const auto marks = read_file(folder_ / "marks.csv");
  std::vector<double> progress;
  std::mutex mutex;
  const auto three = find_tags_in_files(images_, folder_ / "marks.csv", {},
                                        {.progress =
                                             [&](std::string_view, double done) {
                                               const std::lock_guard lock(mutex);
                                               progress.push_back(done);
                                             },
                                         .threads = 3});
  ASSERT_TRUE(one && three && marks);
  EXPECT_EQ(*marks, *read_file(folder_ / "marks.csv"));
  EXPECT_EQ(tags_text(*one), tags_text(*three));
  ASSERT_EQ(progress.size(), images_.size());
  EXPECT_TRUE(std::ranges::is_sorted(progress));
  EXPECT_EQ(progress.back(), 1);
}

TEST_F(FindTags, WhatIsWrongIsRefused) {
  EXPECT_FALSE(find_tags_in_files({}, folder_ / "marks.csv", {}, {}));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(find_tags_in_files(images_, folder_ / "marks.csv", {}, {.stop = stop.get_token()}));
  EXPECT_FALSE(find({.control = folder_ / "nothing.csv"}));
  images_.push_back(folder_ / "nothing.png");
  EXPECT_FALSE(find({}));
}

}  // namespace
}  // namespace collinea
