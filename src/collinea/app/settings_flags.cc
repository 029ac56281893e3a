// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/settings_flags.h"

#include <set>

#include "collinea/app/commands.h"
#include "collinea/app/settings_paths.h"

namespace collinea {

void declare_seed(Flags& flags, SettingsFlags& asked) {
  asked.seed_given = flags.add("seed", asked.settings.seed, "", kSeedHelp);
}

void declare_options(Flags& flags, const std::string& step, SettingsFlags& asked) {
  Settings::each(asked.settings, [&](const char* owner, const char* group, auto& options) {
    if (owner == step)
      flags.add_group(options, group, [&](const char* its, const auto& field, const Given& given) {
        asked.given[its].emplace_back(field.name, given);
      });
  });
}

void apply_flags(SettingsFlags& asked, Settings& settings) {
  make_paths_absolute(asked.settings);
  if (asked.seed_given()) settings.seed = asked.settings.seed;
  Settings::each(std::as_const(asked.settings), [&](const char*, const std::string& group, const auto& from) {
    const auto known = asked.given.find(group);
    if (known == asked.given.end()) return;
    std::set<std::string_view> names;
    for (const auto& [name, given] : known->second)
      if (given()) names.insert(name);
    Settings::each(settings, [&](const char*, const std::string& other, auto& to) {
      if constexpr (std::is_same_v<std::decay_t<decltype(to)>, std::decay_t<decltype(from)>>)
        if (other == group) assign_fields(from, to, [&](std::string_view name) { return names.contains(name); });
    });
  });
}

}  // namespace collinea
