// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "collinea/base/file.h"
#include "collinea/base/nearest_names.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

struct Unit {
  std::string_view name, kind;
  double factor;  // to the first of its kind
};
constexpr double kDegree = std::numbers::pi / 180;
constexpr Unit kUnits[] = {
    {"m", "length", 1},
    {"km", "length", 1e3},
    {"cm", "length", 1e-2},
    {"mm", "length", 1e-3},
    {"um", "length", 1e-6},
    {"µm", "length", 1e-6},
    {"rad", "angle", 1},
    {"deg", "angle", kDegree},
    {"gon", "angle", kDegree * 0.9},
    {"mgon", "angle", kDegree * 0.9e-3},
    {"arcsec", "angle", kDegree / 3600},
    {"px", "pixels", 1},
    {"grey", "grey values", 1},
    {"1", "", 1},
    {"", "", 1},
};

const Unit* unit_named(std::string_view name) {
  const auto* const found =
      std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& unit) { return unit.name == name; });
  return found == std::end(kUnits) ? nullptr : found;
}

// What parts the fields of a table, by its line of titles: 0 for blanks.
char separator_of(std::string_view titles) {
  for (const char separator : {';', ','})
    if (titles.find(separator) != std::string_view::npos) return separator;
  return 0;
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  return separator == 0 ? words_of(line) : fields_of(line, separator);
}

// "x_left[mm]" or "x_left [mm]".
TableColumn column_of(std::string_view title) {
  const auto bracket = title.find('[');
  if (bracket == std::string_view::npos || !title.ends_with(']')) return {std::string(title), ""};
  return {std::string(trimmed(title.substr(0, bracket))),
          std::string(trimmed(title.substr(bracket + 1, title.size() - bracket - 2)))};
}

Result<std::vector<TableColumn>> columns_of(std::string_view line, std::size_t line_number) {
  std::vector<TableColumn> columns;
  for (const std::string_view title : split(line, separator_of(line))) {
    TableColumn column = column_of(title);
    if (column.name.empty() && !column.unit.empty() && !columns.empty() && columns.back().unit.empty()) {
      columns.back().unit = std::move(column.unit);  // a unit that stands apart from its name
      column = columns.back();
      columns.pop_back();
    }
    if (column.name.empty()) return fail(Errc::kBadFormat, fmt::format("line {}: a column has no title", line_number));
    if (unit_named(column.unit) == nullptr)
      return fail(Errc::kBadFormat, fmt::format("line {}: column {} is in \"{}\", which is no unit known here",
                                                line_number, column.name, column.unit));
    const auto same = [&](const TableColumn& other) { return other.name == column.name; };
    if (std::any_of(columns.begin(), columns.end(), same))
      return fail(Errc::kBadFormat, fmt::format("line {}: there are two columns {}", line_number, column.name));
    columns.push_back(std::move(column));
  }
  return columns;
}

bool is_missing(std::string_view word) { return word.empty() || word == "-"; }

}  // namespace

std::optional<double> unit_factor(std::string_view from, std::string_view to) {
  const Unit *const source = unit_named(from), *const target = unit_named(to);
  if (source == nullptr || target == nullptr || source->kind != target->kind) return std::nullopt;
  return source->factor / target->factor;
}

std::optional<std::size_t> TextTable::find(std::string_view name) const {
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (columns[i].name == name) return i;
  return std::nullopt;
}

std::string TextTable::unit_of(std::string_view name) const {
  const auto column = find(name);
  return column ? columns[*column].unit : "";
}

Result<std::vector<std::string>> TextTable::words(std::string_view name) const {
  const auto column = find(name);
  if (!column) {
    std::vector<std::string> names;
    for (const TableColumn& each : columns) names.push_back(each.name);
    return tl::unexpected(
        with_nearest({Errc::kBadFormat, fmt::format("the table has no column {}", name), {}}, name, names));
  }
  std::vector<std::string> found;
  for (const auto& row : rows) found.push_back(row[*column]);
  return found;
}

Result<std::vector<double>> TextTable::numbers(std::string_view name, std::string_view unit) const {
  COLLINEA_TRY(const std::vector<std::string> found, words(name));
  COLLINEA_TRY(std::vector<double> values, numbers_or(name, unit, std::numeric_limits<double>::quiet_NaN()));
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isnan(values[i]))
      return fail(Errc::kBadFormat, fmt::format("row {} of the table gives no {}", i + 1, name));
  return values;
}

Result<std::vector<double>> TextTable::numbers_or(std::string_view name, std::string_view unit, double fallback) const {
  const auto column = find(name);
  if (!column) return std::vector<double>(rows.size(), fallback);
  const std::string& given = columns[*column].unit;
  const auto factor = unit_factor(given.empty() ? unit : std::string_view(given), unit);
  if (!factor) return fail(Errc::kBadFormat, fmt::format("column {} is in {}; wanted are {}", name, given, unit));
  std::vector<double> values;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string& word = rows[i][*column];
    const auto value = finite_number(word);
    if (!value && !is_missing(word))
      return fail(Errc::kBadFormat, fmt::format("row {} of the table: {} is \"{}\", no number", i + 1, name, word));
    values.push_back(value ? *value * *factor : fallback);
  }
  return values;
}

Result<TextTable> parse_text_table(std::string_view text) {
  TextTable table;
  std::size_t line_number = 0;
  char separator = 0;
  for (std::string_view line : lines_of(text)) {
    ++line_number;
    const auto remark = line.find('#');
    if (remark != std::string_view::npos && table.columns.empty() && trimmed(line.substr(0, remark)).empty())
      table.remarks.emplace_back(trimmed(line.substr(remark + 1)));
    line = trimmed(line.substr(0, remark));
    if (line.empty()) continue;
    if (table.columns.empty()) {
      separator = separator_of(line);
      COLLINEA_TRY(table.columns, columns_of(line, line_number));
      continue;
    }
    const auto fields = split(line, separator);
    if (fields.size() != table.columns.size())
      return fail(Errc::kBadFormat, fmt::format("line {} has {} values below {} titles", line_number, fields.size(),
                                                table.columns.size()));
    table.rows.emplace_back(fields.begin(), fields.end());
  }
  if (table.columns.empty()) return fail(Errc::kBadFormat, "the table is empty");
  return table;
}

Result<TextTable> read_text_table(const std::filesystem::path& path) {
  const auto in_file = [&](Error error) { return std::move(error).within(path.string()); };
  COLLINEA_TRY(const std::string bytes, read_file(path));
  COLLINEA_TRY(const auto converted, converted_to_utf8(bytes).map_error(in_file));
  return parse_text_table(converted ? *converted : bytes).map_error(in_file);
}

std::string text_of(const TextTable& table) {
  std::vector<std::vector<std::string>> lines(1);
  for (const TableColumn& column : table.columns)
    lines[0].push_back(column.unit.empty() ? column.name : fmt::format("{}[{}]", column.name, column.unit));
  for (std::vector<std::string> row : table.rows) {
    for (std::string& word : row) {
      std::replace_if(
          word.begin(), word.end(), [](char c) { return c == ' ' || c == '\t'; }, '_');
      if (word.empty()) word = "-";
    }
    lines.push_back(std::move(row));
  }
  std::vector<std::size_t> widths(table.columns.size(), 0);
  for (const auto& line : lines)
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  std::string text;
  for (const std::string& remark : table.remarks) text += "# " + remark + "\n";
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i)
      text += i + 1 == line.size() ? line[i] : fmt::format("{:<{}}  ", line[i], widths[i]);
    text += "\n";
  }
  return text;
}

}  // namespace collinea
