// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/settings_change.h"

#include <nlohmann/json.hpp>
#include <set>

#include "collinea/project/internal/settings_json.h"

namespace collinea {
namespace {

using nlohmann::json;

Result<> check_path(std::string_view name, const std::filesystem::path& path) {
  if (path.empty() || path.is_absolute()) return {};
  return fail(Errc::kBadInput, std::string(name) + " = \"" + path.string() + "\": give an absolute path");
}

Result<> check_paths(const Settings& settings) {
  Result<> verdict;
  Settings::each(settings, [&](const char*, const char*, const auto& options) {
    for_each_field(options, [&](const auto& field, const auto& owner) {
      const auto& value = owner.*field.member;
      using Value = std::decay_t<decltype(value)>;
      if (!verdict) return;
      if constexpr (std::is_same_v<Value, std::filesystem::path>)
        verdict = check_path(field.name, value);
      else if constexpr (std::is_same_v<Value, std::optional<std::filesystem::path>>)
        if (value) verdict = check_path(field.name, *value);
    });
  });
  return verdict;
}

}  // namespace

std::string settings_text(const Settings& settings) {
  json j = {{"photos", settings.photos}, {"seed", settings.seed}, {"options", json::object()}};
  Settings::each(settings, [&](const char*, const char* group, const auto& options) {
    j["options"][group] = options_to_json(options);
  });
  return json_text(j);
}

Result<Settings> changed_settings(const Settings& settings, std::string_view options) {
  Settings changed = settings;
  try {
    const json j = json::parse(options);
    if (!j.is_object()) return fail(Errc::kBadInput, "options must be an object of groups");
    std::set<std::string> known;
    Settings::each(changed, [&](const char*, const char* group, auto& group_options) {
      known.insert(group);
      if (j.contains(group)) options_from_json(j.at(group), group, group_options);
    });
    for (const auto& [group, values] : j.items())
      if (!known.contains(group)) return fail(Errc::kBadInput, "there is no group of options \"" + group + "\"");
  } catch (Error& error) {
    return tl::unexpected(std::move(error));
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
  COLLINEA_TRY(validate_settings(changed));
  COLLINEA_TRY(check_paths(changed));
  return changed;
}

}  // namespace collinea
