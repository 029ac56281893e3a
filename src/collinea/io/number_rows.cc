// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/number_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "collinea/io/text.h"

namespace collinea {

Result<std::vector<NumberRow>> parse_number_rows(std::string_view text, bool named, std::size_t least,
                                                 std::size_t most) {
  std::vector<NumberRow> rows;
  int line_number = 0;
  bool may_be_title = true;
  for (std::string_view line : lines_of(text)) {
    ++line_number;
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    auto fields = line.find(',') == std::string_view::npos ? words_of(line) : fields_of(line, ',');
    NumberRow row{named ? std::string(fields[0]) : std::to_string(rows.size() + 1), {}};
    if (named) fields.erase(fields.begin());
    const bool title = std::none_of(fields.begin(), fields.end(), [](auto field) { return number(field).has_value(); });
    if (std::exchange(may_be_title, false) && title) continue;
    for (const std::string_view field : fields)
      if (const auto value = finite_number(field)) row.numbers.push_back(*value);
    if (row.numbers.size() != fields.size() || row.numbers.size() < least || row.numbers.size() > most)
      return fail(Errc::kBadFormat,
                  fmt::format("line {}: {} numbers{} are wanted", line_number,
                              least == most ? std::to_string(least) : fmt::format("{} to {}", least, most),
                              named ? " behind a name" : ""));
    rows.push_back(std::move(row));
  }
  return rows;
}

Result<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view field : fields_of(text, ',')) {
    const auto value = finite_number(field);
    if (!value) return fail(Errc::kBadInput, fmt::format("\"{}\" is no number", field));
    numbers.push_back(*value);
  }
  return numbers;
}

}  // namespace collinea
