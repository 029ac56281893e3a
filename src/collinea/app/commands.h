// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/app/flags.h"

namespace collinea {

inline constexpr const char* kSeedHelp = "of everything random: same seed, same bits";

// One function a command, each in a file of its own name.
Command run_command();
Command import_command();
/// detect, match, orient, densify, surface, ortho, report: the same command for every step after import.
Command step_command(const std::string& step, const std::string& summary);
Command info_command();
Command adjust_command();
Command export_command();
Command volume_command();
Command profile_command();
Command plan_command();
Command simulate_command();
Command assess_command();
Command stereo_command();
Command rectify_command();

/// All of them, in the order of the help.
std::vector<Command> all_commands();

}  // namespace collinea
