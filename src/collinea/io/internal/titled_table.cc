// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/titled_table.h"

#include <limits>

#include "collinea/io/text.h"

namespace collinea {

Result<TitledTable> TitledTable::parse(std::string_view text, const std::function<bool(const std::string&)>& may_be) {
  TitledTable table(lines_of(text));
  if (!table.next_fields()) return fail(Errc::kBadFormat, "nothing in it: the first row must name the columns");
  for (std::size_t i = 0; i < table.fields_.size(); ++i) {
    const std::string name = lower(table.fields_[i]);
    if (!may_be(name)) return table.bad_row("there is no column \"" + name + "\"");
    if (!table.column_.emplace(name, i).second) return table.bad_row("column " + name + " is there twice");
  }
  return table;
}

Result<bool> TitledTable::next() {
  if (!next_fields()) return false;
  if (fields_.size() > column_.size()) return bad_row("too many fields (decimal commas?)");
  return true;
}

std::string_view TitledTable::field(std::string_view column) const {
  const auto its = column_.find(column);
  return its == column_.end() || its->second >= fields_.size() ? std::string_view{} : fields_[its->second];
}

Result<double> TitledTable::number_in(std::string_view column) const {
  const std::string_view text = field(column);
  if (text.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto value = finite_number(text);
  if (!value) return bad_row(std::string(column) + " \"" + std::string(text) + "\" is not a number");
  return *value;
}

tl::unexpected<Error> TitledTable::bad_row(const std::string& what) const {
  return fail(Errc::kBadFormat, "line " + std::to_string(line_) + ": " + what);
}

bool TitledTable::next_fields() {
  fields_.clear();
  while (static_cast<std::size_t>(line_) < lines_.size()) {
    const std::string_view content = trimmed(lines_[static_cast<std::size_t>(line_++)]);
    if (content.empty() || content.starts_with('#')) continue;
    fields_ = fields_of(content, ',');
    return true;
  }
  return false;
}

}  // namespace collinea
