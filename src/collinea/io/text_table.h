// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

/// A column of a table: what it holds, and in which unit ("" where there is none).
struct TableColumn {
  std::string name, unit;

  bool operator==(const TableColumn&) const = default;
};

/// Measurements and results as text, a row a line; the first line names the columns and their units:
///     # lines like this one are remarks
///     point  x_left[mm]  y_left[mm]  x_right[mm]  y_right[mm]
///     1      -12.001     80.220      -98.771      79.005
/// Columns stand between blanks, or between commas or semicolons where the first line has any. "-" or nothing between
/// commas is a value that is not given. Units are m, km, cm, mm, um; deg, gon, mgon, rad, arcsec; px; grey; 1 or none.
struct TextTable {
  std::vector<std::string> remarks;  ///< lines in front, without their #
  std::vector<TableColumn> columns;
  std::vector<std::vector<std::string>> rows;  ///< each as long as columns

  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const;
  [[nodiscard]] bool has(std::string_view name) const { return find(name).has_value(); }
  /// The unit of a column; "" also where there is no such column.
  [[nodiscard]] std::string unit_of(std::string_view name) const;

  /// A column as it stands. Error: there is none of that name, with the nearest.
  [[nodiscard]] Result<std::vector<std::string>> words(std::string_view name) const;
  /// A column of finite numbers, in `unit`. A column without a unit is taken to be in it. Errors: as words(); a unit of
  /// another kind; a row that does not give a number.
  [[nodiscard]] Result<std::vector<double>> numbers(std::string_view name, std::string_view unit) const;
  /// The same, `fallback` where the column or its value is missing.
  [[nodiscard]] Result<std::vector<double>> numbers_or(std::string_view name, std::string_view unit,
                                                       double fallback) const;
};

/// Errors: no titles, a title twice, a unit that is none, a row of another length (with its line).
[[nodiscard]] Result<TextTable> parse_text_table(std::string_view text);
/// The same of a file (UTF-8, or UTF-16 with its mark); errors name it.
[[nodiscard]] Result<TextTable> read_text_table(const std::filesystem::path& path);

/// The table as text, columns aligned, between blanks. Blanks within a word become "_", an empty word "-".
[[nodiscard]] std::string text_of(const TextTable& table);

/// By what a number of one unit is to be multiplied to be one of another; nothing when these are of different kinds.
[[nodiscard]] std::optional<double> unit_factor(std::string_view from, std::string_view to);

}  // namespace collinea
