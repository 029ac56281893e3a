// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/settings.h"

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "collinea/base/file.h"
#include "collinea/project/internal/settings_json.h"
#include "collinea/project/json_text.h"

namespace collinea {
namespace {

using nlohmann::json;

void read_seed(const json& j, Settings& settings) {
  try {
    settings.seed = read_option<std::uint64_t>(j);
  } catch (const std::exception& error) {
    throw std::invalid_argument(std::string("seed: ") + error.what());
  }
}

bool can_be_kept(const json& j) {
  try {
    return !j.dump().empty();
  } catch (const json::exception&) {
    return false;
  }
}

}  // namespace

Result<Settings> read_settings(const std::filesystem::path& project) {
  const std::filesystem::path path = project / "project.json";
  std::ifstream file(path);
  if (!file)
    return fail(Errc::kNotFound, path.string() + " is missing: make a project with `collinea run PHOTOS -o PROJECT`");
  Settings settings;
  try {
    const json j = json::parse(file);
    settings.photos = j.at("photos").get<std::string>();
    if (j.contains("seed")) read_seed(j.at("seed"), settings);
    const json none = json::object();
    const json& options = j.contains("options") ? j.at("options") : none;  // copies of nested arrays fill the stack
    groups_from_json(options, settings);
  } catch (Error& error) {
    return tl::unexpected(std::move(error).within(path.string()));
  } catch (const std::exception& error) {
    return fail(Errc::kBadFormat, path.string() + ": " + error.what() +
                                      "; correct it, or have it written anew with `collinea run PHOTOS -o PROJECT`");
  }
  COLLINEA_TRY([[maybe_unused]] const auto checked, validate_settings(settings).map([] { return true; }));
  return settings;
}

Result<> write_settings(const std::filesystem::path& project, const Settings& settings) {
  return write_file(project / "project.json", json_text(settings_to_json(settings), 2) + "\n");
}

Result<> validate_settings(const Settings& settings) {
  if (!can_be_kept(settings_to_json(settings)))
    return fail(Errc::kBadInput, (can_be_kept(settings.photos) ? "a name among the options" : settings.photos) +
                                     " is not UTF-8, which is all that project.json can hold: rename it");
  Result<> verdict;
  Settings::each(settings, [&](const char* step, const char* group, const auto& group_options) {
    if (verdict)
      verdict = validate(group_options).map_error([&](Error error) {
        for (OptionName& option : error.options) option.group = group;
        return std::move(error).within(step);
      });
  });
  if (verdict)
    verdict = check_instruments(settings.orient.instruments).map_error([](Error error) {
      return std::move(error).within("orient");
    });
  if (verdict)
    verdict = check_instruments(changed({}, settings.adjust.instruments)).map_error([](Error error) {
      return std::move(error).within("adjust");
    });
  return verdict;
}

std::string options_text(const Settings& settings, const std::string& step) {
  json j;
  j["seed"] = settings.seed;
  Settings::each(settings, [&](const char* owner, const char* group, const auto& group_options) {
    if (step == owner) j[group] = options_to_json(group_options);
  });
  return json_text(j);
}

std::vector<std::pair<std::string, std::string>> chosen_options(const Settings& settings) {
  std::map<std::string, json> defaults;
  const Settings untouched;
  Settings::each(untouched, [&](const char*, const char* group, const auto& options) {
    defaults[group] = options_to_json(options);
  });
  std::vector<std::pair<std::string, std::string>> chosen;
  Settings::each(settings, [&](const char*, const char* group, const auto& options) {
    const json values = options_to_json(options);
    for_each_field(options, [&](const auto& field, const auto&) {
      const std::string name(field.name);
      const json& value = values.at(name);
      if (value == defaults.at(group).at(name)) return;
      const std::string unit(field.unit == "1" || !value.is_number() ? "" : field.unit);
      chosen.emplace_back(group + ("." + name), (value.is_string() ? value.get<std::string>() : json_text(value)) +
                                                    (unit.empty() ? "" : " " + unit));
    });
  });
  if (settings.seed != Settings{}.seed) chosen.emplace_back("seed", std::to_string(settings.seed));
  return chosen;
}

}  // namespace collinea
