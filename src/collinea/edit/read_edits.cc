// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/read_edits.h"

#include <string>

#include "collinea/edit/edit_history.h"
#include "collinea/edit/journal_line.h"
#include "collinea/io/text.h"

namespace collinea {

Result<std::vector<Edit>> read_edits(std::string_view text) {
  EditHistory history;
  const bool ends = text.empty() || text.ends_with('\n');
  const std::vector<std::string_view> lines = lines_of(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string_view line = trimmed(lines[i]);
    if (line.empty() || line.starts_with('#')) continue;
    const bool is_journal = line.starts_with('{');
    Result<Edit> edit = is_journal ? parse_journal_line(line).map([](JournalLine one) { return std::move(one.edit); })
                                   : words_in_line(line).and_then([](const Words& words) { return parse_edit(words); });
    if (!edit && is_journal && !ends && i + 1 == lines.size()) break;  // a killed program left it so
    const Result<> added = edit.and_then([&](Edit one) { return history.add(std::move(one), {}); });
    if (!added) return tl::unexpected(Error(added.error()).within("line " + std::to_string(i + 1)));
  }
  std::vector<Edit> edits;
  for (const EditEntry& entry : history.entries())
    if (entry.is_in_force()) edits.push_back(entry.edit);
  return edits;
}

}  // namespace collinea
