// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/edit/edit.h"

namespace collinea {

/// An entry of a history as it stands now.
struct EditEntry {
  std::uint64_t number = 0;
  std::string time;  ///< UTC, "2026-11-28T01:02:03Z"
  Edit edit = Undo{};
  std::uint64_t target = 0;   ///< of undo and redo: the number of the edit that they are about
  std::uint64_t changed = 0;  ///< number of the last entry that undid or redid it; else its own
  bool undone = false;

  [[nodiscard]] bool is_in_force() const { return target == 0 && !undone; }
};

/// Edits in their order, with what is undone of them. Undo and redo are entries as well: nothing is ever removed. A new
/// edit ends what could be redone.
class EditHistory {
 public:
  [[nodiscard]] std::span<const EditEntry> entries() const { return entries_; }  ///< that of number 1 first
  [[nodiscard]] std::uint64_t number() const { return entries_.size(); }         ///< of the last entry
  [[nodiscard]] const EditEntry& at(std::uint64_t number) const { return entries_.at(number - 1); }

  /// The edit that undo, or redo, would be about; nullptr: there is none.
  [[nodiscard]] const EditEntry* next_undo() const;
  [[nodiscard]] const EditEntry* next_redo() const;

  /// Numbers of the edits of a point, ascending, also of those that are undone.
  [[nodiscard]] std::span<const std::uint64_t> edits_of(const std::string& point) const;
  /// Names that SetPoint gave, in the order of their first entries, also of those that are undone: what is counted so
  /// never changes.
  [[nodiscard]] std::span<const std::string> set_points() const { return set_points_; }

  /// Error: there is nothing to undo or redo.
  [[nodiscard]] Result<> check(const Edit& edit) const;
  /// The same, where there is; the edit becomes the last entry.
  Result<> add(Edit edit, std::string time);

 private:
  std::vector<EditEntry> entries_;
  std::vector<std::uint64_t> to_undo_, to_redo_;  // numbers, the next one last
  std::unordered_map<std::string, std::vector<std::uint64_t>> of_point_;
  std::unordered_set<std::string> is_set_;
  std::vector<std::string> set_points_;
};

}  // namespace collinea
