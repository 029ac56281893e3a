// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

// Names in text files that give every thing a line: file systems allow line breaks in names, those formats do not.

/// Line breaks, tabs and other control characters of a name as \n, \t, \x1b, for messages; bytes above 0x7f are left.
[[nodiscard]] std::string escaped_name(std::string_view name);

[[nodiscard]] bool has_control_character(std::string_view name);

/// Error: an oriented image whose name a line of `format` cannot hold and give back: empty, with a control character,
/// with white space at an end, or, where `hash_begins_remark`, with # in front.
[[nodiscard]] Result<> check_image_names(const Block& block, std::string_view format, bool hash_begins_remark = false);

}  // namespace collinea
