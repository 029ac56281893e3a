// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/settings_change.h"

#include <concepts>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "collinea/base/word_or.h"
#include "collinea/project/internal/settings_json.h"

namespace collinea {
namespace {

using nlohmann::json;

Result<> check_path(std::string_view name, PathKind, const std::filesystem::path& path) {
  if (path.empty() || path.is_absolute()) return {};
  return fail(Errc::kBadInput, std::string(name) + " = \"" + path.string() + "\": give an absolute path");
}

// A text that may be a word is the name of a file where it has folders, or where there is that file.
Result<> check_path(std::string_view name, PathKind kind, const std::string& text) {
  std::error_code error;
  const bool is_file =
      kind == PathKind::kFileOrWord && (text.find('/') != text.npos || std::filesystem::is_regular_file(text, error));
  return is_file ? check_path(name, kind, std::filesystem::path(text)) : Result<>();
}

template <class Enum, class... Other>
Result<> check_path(std::string_view name, PathKind kind, const WordOr<Enum, Other...>& value) {
  if constexpr ((std::same_as<Other, std::filesystem::path> || ...)) {
    const auto* path = value.template get<std::filesystem::path>();
    return path ? check_path(name, kind, *path) : Result<>();
  } else {
    const auto* text = value.template get<std::string>();
    return text ? check_path(name, kind, *text) : Result<>();
  }
}

// Paths of the fields that are given.
Result<> check_paths(const json& given, const Settings& settings) {
  Result<> verdict;
  Settings::each(settings, [&](const char*, const char* group, const auto& options) {
    for_each_field(options, [&](const auto& field, const auto& owner) {
      if (!verdict || !given.contains(group) || !given.at(group).contains(std::string(field.name))) return;
      const auto& value = owner.*field.member;
      if constexpr (requires { check_path(field.name, field.path, value); })
        verdict = check_path(field.name, field.path, value);
      else if constexpr (requires { check_path(field.name, field.path, *value); })
        if (value) verdict = check_path(field.name, field.path, *value);
    });
  });
  return verdict;
}

}  // namespace

std::string settings_text(const Settings& settings) { return json_text(settings_to_json(settings)); }

Result<Settings> changed_settings(const Settings& settings, std::string_view options) {
  Settings changed = settings;
  json given;
  try {
    given = json::parse(options);
    if (!given.is_object()) return fail(Errc::kBadInput, "options must be an object of groups");
    groups_from_json(given, changed);
  } catch (Error& error) {
    return tl::unexpected(std::move(error));
  } catch (const std::exception& error) {
    return fail(Errc::kBadInput, error.what());
  }
  COLLINEA_TRY(validate_settings(changed));
  COLLINEA_TRY(check_paths(given, changed));
  return changed;
}

}  // namespace collinea
