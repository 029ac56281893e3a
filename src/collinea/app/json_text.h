// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace collinea {

/// Text as it stands between the quotes of a JSON string. Bytes that are not UTF-8 (file names may hold any) become
/// "?", control characters blanks.
[[nodiscard]] std::string json_escaped(std::string_view text);

}  // namespace collinea
