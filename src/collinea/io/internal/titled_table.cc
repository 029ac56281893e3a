// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/titled_table.h"

#include <algorithm>
#include <limits>

#include "collinea/io/internal/separators.h"
#include "collinea/io/text.h"

namespace collinea {

Result<TitledTable> TitledTable::parse(std::string_view text, const std::function<bool(const std::string&)>& may_be) {
  TitledTable table(lines_of(text));
  if (!table.next_fields()) return fail(Errc::kBadFormat, "nothing in it: the first row must name the columns");
  for (std::size_t i = 0; i < table.fields_.size(); ++i) {
    const std::string name = lower(table.fields_[i]);
    if (!may_be(name))
      return table.bad_row("there is no column \"" + name + "\"" + separator_hint(table.fields_[i], table.separator_));
    if (!table.column_.emplace(name, i).second) return table.bad_row("column " + name + " is there twice");
  }
  return table;
}

Result<bool> TitledTable::next() {
  if (!next_fields()) return false;
  if (fields_.size() == column_.size()) return true;
  if (fields_.size() > column_.size()) return bad_row("too many fields (decimal commas?)");
  return bad_row(std::to_string(fields_.size()) + (fields_.size() == 1 ? " field" : " fields") +
                 " where the first row names " + std::to_string(column_.size()) +
                 " columns; an empty field keeps its separator" +
                 (fields_.size() == 1 ? separator_hint(fields_[0], separator_) : ""));
}

std::string_view TitledTable::field(std::string_view column) const {
  const auto its = column_.find(column);
  return its == column_.end() || its->second >= fields_.size() ? std::string_view{} : fields_[its->second];
}

Result<double> TitledTable::number_in(std::string_view column) const {
  const std::string_view text = field(column);
  if (text.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto value = finite_number(text);
  if (!value)
    return bad_row(std::string(column) + " \"" + std::string(text) + "\" is not a number" + number_hint(text));
  return *value;
}

tl::unexpected<Error> TitledTable::bad_row(const std::string& what) const {
  return fail(Errc::kBadFormat, "line " + std::to_string(line_) + ": " + what);
}

bool TitledTable::next_fields() {
  fields_.clear();
  while (static_cast<std::size_t>(line_) < lines_.size()) {
    const std::string_view line = lines_[static_cast<std::size_t>(line_++)], content = trimmed(line);
    if (content.empty() || content.starts_with('#')) continue;
    if (column_.empty()) separator_ = separator_of_titles(content);
    fields_ = fields_between(line, separator_);
    if (std::all_of(fields_.begin(), fields_.end(), [](auto field) { return field.empty(); })) continue;
    return true;
  }
  return false;
}

}  // namespace collinea
