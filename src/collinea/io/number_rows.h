// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

/// What a line of a list holds.
struct NumberRow {
  std::string name;             ///< the first word; where rows have no names its number, from 1
  std::vector<double> numbers;  ///< finite
};

/// Rows of numbers between commas or white space, each behind a name if `named`. Empty lines, what follows a # and a
/// title in front (a line without a number) are passed over. Errors, with the line: another count of numbers than from
/// `least` to `most`, something that is no finite number.
[[nodiscard]] Result<std::vector<NumberRow>> parse_number_rows(std::string_view text, bool named, std::size_t least,
                                                               std::size_t most);

/// Finite numbers between commas. Error: the field that is none.
[[nodiscard]] Result<std::vector<double>> parse_numbers(std::string_view text);

}  // namespace collinea
