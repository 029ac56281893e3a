// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/settings_change.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

TEST(SettingsChange, OnlyWhatIsGivenChanges) {
  Settings before;
  before.seed = 7;
  before.photos = "/photos";
  const auto after = changed_settings(before, R"({"verify": {"max_error_px": 3.25}})");
  ASSERT_TRUE(after) << after.error().message;
  EXPECT_EQ(after->verify.max_error_px, 3.25);
  auto wanted = nlohmann::json::parse(settings_text(before));
  wanted["options"]["verify"]["max_error_px"] = 3.25;
  EXPECT_EQ(nlohmann::json::parse(settings_text(*after)), wanted);
}

TEST(SettingsChange, WhatIsNoOptionIsRefused) {
  for (const char* wrong : {"", "[]", "{", R"({"nothing": {}})", R"({"verify": {"nothing": 1}})", R"({"verify": 3})",
                            R"({"verify": {"max_error_px": "two"}})", R"({"verify": {"max_error_px": -1}})",
                            R"({"densify": {"threads": 3}})", R"({"import": {"control": 3}})"})
    EXPECT_FALSE(changed_settings({}, wrong)) << wrong;
}

// The server works in another folder than who types the name.
TEST(SettingsChange, PathsMustBeAbsolute) {
  EXPECT_FALSE(changed_settings({}, R"({"orient": {"orientation": "other/cameras.txt"}})"));
  EXPECT_TRUE(changed_settings({}, R"({"orient": {"orientation": "/other/cameras.txt"}})"));
  EXPECT_TRUE(changed_settings({}, R"({"orient": {"orientation": null}})"));
}

TEST(SettingsChange, TextsThatAreNamesOfFilesMustBeAbsolute) {
  const TestFolder folder;
  ASSERT_TRUE(write_file(folder / "geoid.gtx", "grid"));
  const auto heights = [](const std::string& text) {
    const auto changed = changed_settings({}, R"({"import": {"heights": ")" + text + "\"}}");
    return changed ? "" : changed.error().message;
  };
  EXPECT_EQ(heights("EPSG:5773"), "");
  EXPECT_EQ(heights("ellipsoidal"), "");
  EXPECT_EQ(heights((folder / "geoid.gtx").string()), "");
  EXPECT_NE(heights("grids/geoid.gtx").find("absolute path"), std::string::npos);
  EXPECT_NE(heights("./geoid.gtx").find("absolute path"), std::string::npos);
  const auto before = std::filesystem::current_path();
  EXPECT_EQ(heights("geoid.gtx"), "");  // a word, as far as can be seen
  std::filesystem::current_path(folder / "");
  EXPECT_NE(heights("geoid.gtx").find("absolute path"), std::string::npos);
  std::filesystem::current_path(before);
}

// What was asked on the command line stays as it is.
TEST(SettingsChange, OnlyGivenPathsAreChecked) {
  Settings before;
  before.orient.orientation = "other/cameras.txt";
  EXPECT_TRUE(changed_settings(before, R"({"verify": {"max_error_px": 3}})"));
  EXPECT_TRUE(changed_settings(before, R"({"orient": {"max_error_px": 3}})"));
  EXPECT_FALSE(changed_settings(before, R"({"orient": {"orientation": "other/cameras.txt"}})"));
}

}  // namespace
}  // namespace collinea
