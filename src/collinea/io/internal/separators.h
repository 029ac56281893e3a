// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace collinea {

// Tables come from spreadsheets and from people: with commas, semicolons or tabs between their fields, and with decimal
// commas. What separates is taken from the file where it says so beyond doubt; where not, errors name what was found.

/// What separates the fields of a row of titles: a comma; where it has none a semicolon; without either a tab.
[[nodiscard]] char separator_of_titles(std::string_view titles);

/// The fields of a line between such separators, trimmed. An empty first or last field of a line with tabs counts.
[[nodiscard]] std::vector<std::string_view> fields_between(std::string_view line, char separator);

/// "12,5" and "-1033,70": one comma between digits, no point.
[[nodiscard]] bool has_decimal_comma(std::string_view field);

/// What to say behind an error about a number that could not be read: how to write a decimal comma; else empty.
[[nodiscard]] std::string number_hint(std::string_view field);

/// What to say behind an error about a line that could not be taken apart: the separator that it seems to have, and the
/// one that is expected (',', ';', '\t', or ' ' for white space); else empty.
[[nodiscard]] std::string separator_hint(std::string_view line, char expected);

}  // namespace collinea
