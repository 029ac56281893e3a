// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/settings.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "collinea/io/file.h"

namespace collinea {
namespace {

using nlohmann::json;

template <class T>
json to_json(const T& value) {
  if constexpr (requires { value.has_value(); })
    return value ? json(*value) : json(nullptr);
  else
    return json(value);
}

template <class T>
void from_json(const json& j, T& value) {
  if constexpr (requires { value.has_value(); }) {
    if (j.is_null())
      value.reset();
    else
      value = j.get<typename T::value_type>();
  } else {
    value = j.get<T>();
  }
}

template <class Options>
json options_to_json(const Options& options) {
  json j = json::object();
  Options::describe([&](const auto& field) { j[std::string(field.name)] = to_json(options.*field.member); });
  return j;
}

template <class Options>
void options_from_json(const json& j, Options& options) {
  Options::describe([&](const auto& field) {
    const std::string name(field.name);
    if (j.contains(name)) from_json(j.at(name), options.*field.member);
  });
}

}  // namespace

Result<Settings> read_settings(const std::filesystem::path& project) {
  const std::filesystem::path path = project / "project.json";
  std::ifstream file(path);
  if (!file) return fail(Errc::kNotFound, path.string() + " is missing: make a project with `collinea run PHOTOS -o PROJECT`");
  Settings settings;
  try {
    const json j = json::parse(file);
    settings.photos = j.at("photos").get<std::string>();
    settings.seed = j.value("seed", std::uint64_t{1});
    const json options = j.value("options", json::object());
    Settings::each(settings, [&](const char*, const char* group, auto& group_options) {
      if (options.contains(group)) options_from_json(options.at(group), group_options);
    });
  } catch (const json::exception& error) {
    return fail(Errc::kBadFormat, path.string() + ": " + error.what());
  }
  COLLINEA_TRY([[maybe_unused]] const auto checked, validate_settings(settings).map([] { return true; }));
  return settings;
}

Result<> write_settings(const std::filesystem::path& project, const Settings& settings) {
  json j;
  j["photos"] = settings.photos;
  j["seed"] = settings.seed;
  Settings::each(settings, [&](const char*, const char* group, const auto& group_options) {
    j["options"][group] = options_to_json(group_options);
  });
  return write_file(project / "project.json", j.dump(2) + "\n");
}

Result<> validate_settings(const Settings& settings) {
  Result<> verdict;
  Settings::each(settings, [&](const char* step, const char*, const auto& group_options) {
    if (verdict)
      verdict = validate(group_options).map_error([&](Error error) { return std::move(error).within(step); });
  });
  return verdict;
}

std::string options_text(const Settings& settings, const std::string& step) {
  json j;
  j["seed"] = settings.seed;
  Settings::each(settings, [&](const char* owner, const char* group, const auto& group_options) {
    if (step == owner) j[group] = options_to_json(group_options);
  });
  return j.dump();
}

}  // namespace collinea
