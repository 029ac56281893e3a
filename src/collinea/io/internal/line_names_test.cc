// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/line_names.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/io/adjustment_file.h"
#include "collinea/io/bundler.h"
#include "collinea/io/colmap.h"
#include "collinea/io/opk.h"

namespace collinea {
namespace {

// Two images over one point; the first is called so.
Block block_with(const std::string& name) {
  Block block;
  block.cameras[{0}] = ideal_camera(1000, 1200, 800);
  block.cameras[{0}].name = "camera";
  block.points[{0}] = {{1, 2, 3}, {}};
  for (std::uint32_t i = 0; i < 2; ++i) {
    block.images[{i}].file = i == 0 ? name : "other.jpg";
    block.images[{i}].camera = {0};
    // Looking down from 100 m.
    set_pose(block, {i}, {Eigen::Quaterniond(0, 1, 0, 0), Eigen::Vector3d(10.0 * i, 0, 100)});
    Observation o;
    o.image = {i};
    o.point = {0};
    o.pixel = project(block.cameras[{0}], pose_of(block, {i}) * Eigen::Vector3d(1, 2, 3)).value();
    block.observations.push_back(o);
  }
  return block;
}

// The first image's name after it went through a format; the error where that cannot be.
using Trip = Result<std::string> (*)(const Block& block, const TestFolder& folder);

Result<std::string> through_colmap(const Block& block, const TestFolder& folder) {
  COLLINEA_TRY(const auto findings, write_colmap(folder / "colmap", block, ColmapEncoding::kText));
  COLLINEA_TRY(const Block back, read_colmap(folder / "colmap"));
  return back.images.at({0}).file;
}

Result<std::string> through_bundler(const Block& block, const TestFolder& folder) {
  COLLINEA_TRY(const auto findings, write_bundler(folder / "bundler", block));
  COLLINEA_TRY(const Block back, read_bundler(folder / "bundler", [](const std::string&) -> Result<ImageSize> {
                 return ImageSize{1200, 800};
               }));
  return back.images.at({0}).file;
}

Result<std::string> through_opk(const Block& block, const TestFolder& folder) {
  COLLINEA_TRY(write_opk(folder / "opk.txt", block));
  COLLINEA_TRY(const auto rows, read_opk(folder / "opk.txt"));
  return rows.at(0).file;
}

Result<std::string> through_adjustment_file(const Block& block, const TestFolder& folder) {
  AdjustmentFile file;
  file.block = block;
  COLLINEA_TRY(write_adjustment_file(folder / "a.txt", file));
  COLLINEA_TRY(const std::string text, read_file(folder / "a.txt"));
  COLLINEA_TRY(const AdjustmentFile back, parse_adjustment_file(text));
  return back.block.images.at({0}).file;
}

constexpr std::pair<const char*, Trip> kTrips[] = {{"colmap", through_colmap},
                                                   {"bundler", through_bundler},
                                                   {"opk", through_opk},
                                                   {"adjustment file", through_adjustment_file}};

TEST(LineNames, OddNamesComeBackAsTheyWere) {
  const TestFolder folder;
  for (const std::string name : {"a b  c.jpg", "flight 1/x.jpg", "\"quoted\".jpg", "photo 1 2", "7", "a#b.jpg",
                                 "f\xc3\xa4hre.jpg", "1 2 3 4 5 6 7 8", "back\\slash n.jpg"})
    for (const auto& [format, trip] : kTrips) {
      const auto back = trip(block_with(name), folder);
      ASSERT_TRUE(back) << format << ": " << name << ": " << back.error().message;
      EXPECT_EQ(*back, name) << format;
    }
}

TEST(LineNames, WhatDoesNotFitIntoALineIsRefusedAndNamed) {
  const TestFolder folder;
  for (const auto& [name, shown] : {std::pair<std::string, std::string>{"a\nb.jpg", "a\\nb.jpg"},
                                    {"a\rb.jpg", "a\\rb.jpg"},
                                    {"\x1b[2Ja.jpg", "\\x1b[2Ja.jpg"},
                                    {std::string("a\0b", 3), "a\\x00b"},
                                    {"x 1 2 3 0 0 0\n", "x 1 2 3 0 0 0\\n"}})
    for (const auto& [format, trip] : kTrips) {
      const auto back = trip(block_with(name), folder);
      ASSERT_FALSE(back) << format << ": " << shown;
      EXPECT_NE(back.error().message.find("\"" + shown + "\""), std::string::npos) << back.error().message;
    }
}

TEST(LineNames, ATabIsKeptInQuotesAndRefusedElsewhere) {
  const TestFolder folder;
  for (const auto& [format, trip] : kTrips) {
    const auto back = trip(block_with("a\tb.jpg"), folder);
    if (trip == &through_adjustment_file)
      EXPECT_EQ(back.value(), "a\tb.jpg");
    else
      EXPECT_FALSE(back) << format;
  }
}

TEST(LineNames, WhatALineWouldLoseIsRefused) {
  for (const std::string name : {"", " a.jpg", "a.jpg "}) EXPECT_FALSE(check_image_names(block_with(name), "a list"));
  EXPECT_TRUE(check_image_names(block_with("#1.jpg"), "a list"));
  EXPECT_FALSE(check_image_names(block_with("#1.jpg"), "a list", true));
}

TEST(LineNames, EscapedShowsWhatCannotBeSeen) {
  EXPECT_EQ(escaped_name("a\tb\r\n\x7f \xc3\xa4"), "a\\tb\\r\\n\\x7f \xc3\xa4");
  EXPECT_TRUE(has_control_character("\x7f"));
  EXPECT_FALSE(has_control_character("\xc3\xa4 #"));
}

}  // namespace
}  // namespace collinea
