// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collinea/app/flags.h"
#include "collinea/project/settings.h"

namespace collinea {

/// Flags of one step over the settings that a project has.
struct SettingsFlags {
  Settings settings;  ///< holds what the flags say; only those given go into the project
  Given seed_given;
  std::map<std::string, std::vector<std::pair<std::string_view, Given>>> given;  ///< by group
};

/// Declares --seed and the options of the step.
void declare_seed(Flags& flags, SettingsFlags& asked);
void declare_options(Flags& flags, const std::string& step, SettingsFlags& asked);

/// Puts the options that were given into the settings.
void apply_flags(SettingsFlags& asked, Settings& settings);

}  // namespace collinea
