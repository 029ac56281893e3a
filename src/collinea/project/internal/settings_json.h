// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "collinea/base/options.h"
#include "collinea/project/json_text.h"

namespace collinea {

// A value as project.json holds it: words of enumerations, "auto" or null for nothing.
template <class T>
nlohmann::json option_json(const T& value) {
  if constexpr (Worded<T>)
    return nlohmann::json(word_of(value));
  else if constexpr (detail::kIsWordOr<T>)
    return nlohmann::json(value.text());
  else if constexpr (std::is_same_v<T, std::filesystem::path>)
    return nlohmann::json(value.string());
  else
    return nlohmann::json(value);
}

template <class Owner, class T>
nlohmann::json option_json(const Field<Owner, T>& field, const Owner& owner) {
  const T& value = owner.*field.member;
  if constexpr (requires { value.has_value(); }) {
    if (!value) return field.automatic ? nlohmann::json("auto") : nlohmann::json(nullptr);
    return option_json(*value);
  } else {
    return option_json(value);
  }
}

// Throws what the reader of the file turns into words.
template <class T>
T read_option(const nlohmann::json& j) {
  if constexpr (std::is_same_v<T, std::filesystem::path> || detail::kIsWordOr<T>) {
    return j.get<std::string>();
  } else {
    if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
      if (!j.is_number_integer()) throw std::invalid_argument("must be a whole number");
      const bool fits =
          j.is_number_unsigned() ? std::in_range<T>(j.get<std::uint64_t>()) : std::in_range<T>(j.get<std::int64_t>());
      if (!fits) throw std::invalid_argument(json_text(j) + " is out of range");
    }
    return j.get<T>();
  }
}

// The same; a word that is no choice is thrown as the Error that says so.
template <class Owner, class T>
void read_option(const nlohmann::json& j, const Field<Owner, T>& field, Owner& owner) {
  using Value = OptionValue<T>;
  T& value = owner.*field.member;
  if constexpr (requires { value.has_value(); }) {
    if (j.is_null() || (field.automatic && j == "auto")) return value.reset();
  }
  if constexpr (Worded<Value>) {
    const auto word = j.get<std::string>();
    const auto known = from_word<Value>(word);
    if (!known) throw not_a_choice(field.name, word, field.choices());
    value = *known;
  } else {
    value = read_option<Value>(j);
    if constexpr (std::is_same_v<T, std::optional<std::filesystem::path>>)
      if (value->empty()) value.reset();
  }
}

template <class Options>
nlohmann::json options_to_json(const Options& options) {
  nlohmann::json j = nlohmann::json::object();
  for_each_field(options,
                 [&](const auto& field, const auto& owner) { j[std::string(field.name)] = option_json(field, owner); });
  return j;
}

// Throws what the reader of the file turns into words.
template <class Options>
void options_from_json(const nlohmann::json& j, const std::string& group, Options& options) {
  std::set<std::string> known;
  for_each_field(options, [&](const auto& field, auto& owner) {
    const std::string name(field.name);
    known.insert(name);
    if (!j.contains(name)) return;
    try {
      read_option(j.at(name), field, owner);
    } catch (const std::exception& error) {
      throw std::invalid_argument("options." + group + "." + name + ": " + error.what());
    }
  });
  for (const auto& [name, value] : j.items())
    if (!known.contains(name))
      throw std::invalid_argument("options." + group + "." + name + ": there is no such option");
}

// All of project.json. Settings list their groups of options by each().
template <class Settings>
nlohmann::json settings_to_json(const Settings& settings) {
  nlohmann::json j = {{"photos", settings.photos}, {"seed", settings.seed}, {"options", nlohmann::json::object()}};
  Settings::each(settings, [&](const char*, const char* group, const auto& options) {
    j["options"][group] = options_to_json(options);
  });
  return j;
}

// Reads the groups that are given, those of "options" in project.json. Throws what the reader of the file turns into
// words.
template <class Settings>
void groups_from_json(const nlohmann::json& options, Settings& settings) {
  std::set<std::string> known;
  Settings::each(settings, [&](const char*, const char* group, auto& group_options) {
    known.insert(group);
    if (options.contains(group)) options_from_json(options.at(group), group, group_options);
  });
  for (const auto& [group, values] : options.items())
    if (!known.contains(group)) throw std::invalid_argument("options." + group + ": there is no such group of options");
}

}  // namespace collinea
