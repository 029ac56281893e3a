// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

/// A table whose first row names its columns, in any order and case, and says with what separates its titles what
/// separates all fields: commas, semicolons or tabs. Every row has a field for every title, empty ones included: a
/// field that is missing would move those behind it to other columns. Empty lines, rows of separators alone and lines
/// that begin with # are passed over. Views point into the caller's text, which is UTF-8. Every error names the line.
class TitledTable {
 public:
  /// Reads the row of titles. `may_be` tells the names that columns may have. Errors: another name, one that is there
  /// twice, no row at all.
  [[nodiscard]] static Result<TitledTable> parse(std::string_view text,
                                                 const std::function<bool(const std::string&)>& may_be);

  [[nodiscard]] bool has(std::string_view column) const { return column_.find(column) != column_.end(); }
  /// On to the next row; false after the last. Error: more fields than titles, or fewer.
  [[nodiscard]] Result<bool> next();
  [[nodiscard]] int line() const { return line_; }  ///< of this row, from 1

  /// The field of this row; empty where nothing stands or there is no such column.
  [[nodiscard]] std::string_view field(std::string_view column) const;
  /// The finite number of a field, NaN where it is empty.
  [[nodiscard]] Result<double> number_in(std::string_view column) const;
  [[nodiscard]] tl::unexpected<Error> bad_row(const std::string& what) const;

 private:
  explicit TitledTable(std::vector<std::string_view> lines) : lines_(std::move(lines)) {}
  bool next_fields();

  std::vector<std::string_view> lines_, fields_;
  std::map<std::string, std::size_t, std::less<>> column_;
  char separator_ = ',';
  int line_ = 0;
};

}  // namespace collinea
