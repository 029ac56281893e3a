// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/edit/edit.h"

namespace collinea {

/// Words of a command.
using Words = std::vector<std::string>;

/// One line of a journal: a JSON object
///
///     {"number":3,"time":"2026-11-28T01:02:03Z","command":["unmark","P1","a.jpg"],"replaced":[["mark","P1","a.jpg","12","30","0.5"]]}
struct JournalLine {
  std::uint64_t number = 0;  ///< of the entry, and of its line, from 1
  std::string time;          ///< UTC
  Edit edit = Undo{};
  /// What was there before, as the commands that would bring it back. For people and other programs: undoing asks what
  /// was imported and the edits that are in force, so that it holds when the photographs were imported anew.
  std::vector<Words> replaced = {};
};

inline constexpr std::size_t kLongestLine = std::size_t{4} << 20;  ///< bytes: a point in some 50,000 images

/// Without a line break at its end.
[[nodiscard]] std::string text_of(const JournalLine& line);
/// Errors: no such object, a command that is none; text_of() makes an equal line of what is read.
[[nodiscard]] Result<JournalLine> parse_journal_line(std::string_view text);

}  // namespace collinea
