// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/edit/edit.h"

namespace collinea {

/// The edits in force of a file: a journal, or a list of commands, one a line (empty lines and those that begin with #
/// are none). What it undoes itself is left out. Errors name the line.
[[nodiscard]] Result<std::vector<Edit>> read_edits(std::string_view text);

}  // namespace collinea
