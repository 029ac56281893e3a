// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "collinea/project/settings.h"

namespace collinea {

/// The settings as project.json holds them, on one line.
[[nodiscard]] std::string settings_text(const Settings& settings);

/// The settings with other values for some of the options: {"orient": {"max_error_px": 2}}, by groups as in
/// project.json. Errors: not JSON, unknown group or option, value of a wrong kind or out of range, a path that is given
/// and not absolute.
[[nodiscard]] Result<Settings> changed_settings(const Settings& settings, std::string_view options);

}  // namespace collinea
