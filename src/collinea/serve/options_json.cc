// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/options_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "collinea/project/settings_change.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

template <class Value>
constexpr std::string_view kind_of() {
  if constexpr (std::is_same_v<Value, bool>)
    return "flag";
  else if constexpr (std::is_integral_v<Value>)
    return "whole";
  else if constexpr (std::is_floating_point_v<Value>)
    return "number";
  else if constexpr (std::is_same_v<Value, std::filesystem::path>)
    return "path";
  else if constexpr (Worded<Value>)
    return "word";
  else if constexpr (detail::kIsWordOr<Value>)
    return "word_or_text";
  else
    return "text";
}

std::string_view path_word(PathKind kind) {
  switch (kind) {
    case PathKind::kNone:
      return "";
    case PathKind::kFile:
      return "file";
    case PathKind::kFolder:
      return "folder";
    case PathKind::kFileOrFolder:
      return "file_or_folder";
    case PathKind::kFileOrWord:
      return "file_or_word";
    case PathKind::kOutput:
      return "output";
  }
  return "";
}

template <class Owner, class T>
json field_json(const Field<Owner, T>& field, const json& value) {
  json one = {{"name", field.name},
              {"unit", field.unit},
              {"help", field.help},
              {"kind", kind_of<OptionValue<T>>()},
              {"default", value}};
  if (std::isfinite(field.min)) one["min"] = field.min;
  if (std::isfinite(field.max)) one["max"] = field.max;
  if (field.automatic) one["automatic"] = *field.automatic;
  if (const auto word = path_word(field.path); !word.empty()) one["path"] = word;
  for (const Choice& choice : field.choices())
    one["choices"].push_back({{"word", choice.word}, {"meaning", choice.meaning}});
  return one;
}

}  // namespace

std::string options_json() {
  const Settings untouched;
  const json defaults = json::parse(settings_text(untouched)).at("options");
  json all = json::array();
  Settings::each(untouched, [&](const char* step, const char* group, const auto& options) {
    json one = {{"step", step}, {"group", group}, {"options", json::array()}};
    for_each_field(options, [&](const auto& field, const auto&) {
      one["options"].push_back(field_json(field, defaults.at(group).at(std::string(field.name))));
    });
    all.push_back(std::move(one));
  });
  return all.dump();
}

}  // namespace collinea
