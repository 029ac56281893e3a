// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/cloud/cloud_edits.h"
#include "collinea/edit/edit_history.h"

namespace collinea {

/// {"number", "undo", "redo", "entries": [{"number", "time", "command", "undone"}], "left_out"}: entries that were
/// made, undone or redone behind the entry `since`, the last `most` of them; "undo" and "redo" are the commands that
/// these would be about as one line, or null.
[[nodiscard]] std::string edits_json(const EditHistory& history, std::uint64_t since, std::size_t most);

/// {"file", "other", "regions": [{"action", "class", "ring", "low_m", "high_m"}]}: the cloud of a project that a viewer
/// can read by ranges, else one in another form (paths below the project, or null), and the edits of it in force.
[[nodiscard]] std::string cloud_json(const std::filesystem::path& project, std::span<const CloudRegion> regions);

/// The command in {"command": [...]}. Errors: no such object, no such command.
[[nodiscard]] Result<Edit> edit_in(std::string_view body);

}  // namespace collinea
