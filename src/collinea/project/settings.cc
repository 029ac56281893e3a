// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/settings.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <utility>

#include "collinea/base/file.h"
#include "collinea/cloud/las.h"
#include "collinea/orient/additional.h"
#include "collinea/project/json_text.h"

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
      from_json(j, value.emplace());
  } else {
    if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
      if (!j.is_number_integer()) throw std::invalid_argument("must be a whole number");
      const bool fits =
          j.is_number_unsigned() ? std::in_range<T>(j.get<std::uint64_t>()) : std::in_range<T>(j.get<std::int64_t>());
      if (!fits) throw std::invalid_argument(json_text(j) + " is out of range");
    }
    value = j.get<T>();
  }
}

template <class Options>
json options_to_json(const Options& options) {
  json j = json::object();
  Options::describe([&](const auto& field) { j[std::string(field.name)] = to_json(options.*field.member); });
  return j;
}

void read_seed(const json& j, Settings& settings) {
  try {
    from_json(j, settings.seed);
  } catch (const std::exception& error) {
    throw std::invalid_argument(std::string("seed: ") + error.what());
  }
}

// Throws what the reader of the file turns into words.
template <class Options>
void options_from_json(const json& j, const std::string& group, Options& options) {
  std::set<std::string> known;
  Options::describe([&](const auto& field) {
    const std::string name(field.name);
    known.insert(name);
    if (!j.contains(name)) return;
    try {
      from_json(j.at(name), options.*field.member);
    } catch (const std::exception& error) {
      throw std::invalid_argument("options." + group + "." + name + ": " + error.what());
    }
  });
  for (const auto& [name, value] : j.items())
    if (!known.contains(name))
      throw std::invalid_argument("options." + group + "." + name + ": there is no such option");
}

json settings_to_json(const Settings& settings) {
  json j;
  j["photos"] = settings.photos;
  j["seed"] = settings.seed;
  Settings::each(settings, [&](const char*, const char* group, const auto& group_options) {
    j["options"][group] = options_to_json(group_options);
  });
  return j;
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
    const json options = j.value("options", json::object());
    std::set<std::string> known;
    Settings::each(settings, [&](const char*, const char* group, auto& group_options) {
      known.insert(group);
      if (options.contains(group)) options_from_json(options.at(group), group, group_options);
    });
    for (const auto& [group, values] : options.items())
      if (!known.contains(group))
        throw std::invalid_argument("options." + group + ": there is no such group of options");
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
  Settings::each(settings, [&](const char* step, const char*, const auto& group_options) {
    if (verdict)
      verdict = validate(group_options).map_error([&](Error error) { return std::move(error).within(step); });
  });
  const std::string& calibration = settings.orient.calibration;
  if (verdict && std::find(kCalibrations.begin(), kCalibrations.end(), calibration) == kCalibrations.end())
    return fail(Errc::kBadInput,
                "orient: calibration = \"" + calibration + "\": choose auto, none, focal, focal_radial or brown");
  if (const auto set = additional_named(settings.orient.additional); verdict && !set)
    return tl::unexpected(Error(set.error()).within("orient"));
  if (verdict)
    verdict = check_instruments(settings.orient.instruments).map_error([](Error error) {
      return std::move(error).within("orient");
    });
  const std::string& pairs = settings.pairs.pairs;
  if (verdict && std::find(kPairChoices.begin(), kPairChoices.end(), pairs) == kPairChoices.end())
    return fail(Errc::kBadInput, "match: pairs = \"" + pairs + "\": choose auto or all");
  const std::string& mode = settings.orient.mode;
  if (verdict && std::find(kOrientModes.begin(), kOrientModes.end(), mode) == kOrientModes.end())
    return fail(Errc::kBadInput, "orient: mode = \"" + mode + "\": choose auto, incremental or global");
  const std::string& cloud = settings.densify.cloud;
  if (verdict && !las_form_of(cloud))
    return fail(Errc::kBadInput, "densify: cloud = \"" + cloud + "\": choose las, laz or copc");
  const auto& resolution = settings.densify.resolution;
  if (verdict && resolution && !shrink_of(*resolution))
    return fail(Errc::kBadInput, "densify: resolution = \"" + *resolution + "\": choose full, half or quarter");
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
    std::decay_t<decltype(options)>::describe([&](const auto& field) {
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
