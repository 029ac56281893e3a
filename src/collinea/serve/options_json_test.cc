// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/options_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "collinea/project/settings_change.h"
#include "collinea/steps/step_list.h"

namespace collinea {
namespace {

using nlohmann::json;

// Whatever a form shows as the default is taken again as it stands.
TEST(OptionsJson, DefaultsAreValuesThatTheProjectTakes) {
  json options;
  for (const json& group : json::parse(options_json())) {
    EXPECT_TRUE(from_word<Step>(group.at("step").get<std::string>())) << group.at("step");
    for (const json& option : group.at("options")) {
      EXPECT_FALSE(option.at("help").get<std::string>().empty()) << option.at("name");
      options[group.at("group").get<std::string>()][option.at("name").get<std::string>()] = option.at("default");
    }
  }
  const auto same = changed_settings({}, options.dump());
  ASSERT_TRUE(same) << same.error().message;
  EXPECT_EQ(settings_text(*same), settings_text({}));
}

TEST(OptionsJson, FieldsAreAsDescribed) {
  for (const json& group : json::parse(options_json())) {
    if (group.at("group") != "verify") continue;
    const json& option = group.at("options").at(0);
    EXPECT_EQ(group.at("step"), "match");
    EXPECT_EQ(option.at("name"), "max_error_px");
    EXPECT_EQ(option.at("unit"), "px");
    EXPECT_EQ(option.at("kind"), "number");
    EXPECT_EQ(option.at("default"), 2.5);
    EXPECT_EQ(option.at("min"), 1e-6);
    EXPECT_FALSE(option.contains("max"));
    return;
  }
  ADD_FAILURE() << "no group verify";
}

TEST(OptionsJson, WordsHaveTheirChoices) {
  int words = 0;
  for (const json& group : json::parse(options_json()))
    for (const json& option : group.at("options"))
      if (option.at("kind") == "word") {
        ++words;
        const json& choices = option.at("choices");
        const bool has_default = std::any_of(choices.begin(), choices.end(), [&](const json& choice) {
          return choice.at("word") == option.at("default");
        });
        EXPECT_TRUE(has_default || option.at("default").is_null()) << option;
      }
  EXPECT_GT(words, 10);
}

}  // namespace
}  // namespace collinea
