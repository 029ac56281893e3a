// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/settings_change.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

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

}  // namespace
}  // namespace collinea
