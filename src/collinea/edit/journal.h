// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/edit/edit_history.h"
#include "collinea/edit/journal_line.h"

namespace collinea {

/// An edit that is to be appended.
struct NewEdit {
  Edit edit;
  std::vector<Words> replaced = {};
};

/// PROJECT/journal.jsonl: all edits of a project in their order, a line each. Only ever appended to: undo and redo are
/// entries as well. Whoever appends holds a lock of the file, for moments; readers hold none. What is in memory are the
/// lines up to a position of the file; refresh() reads on from there. Not to be used by several threads at once.
class Journal {
 public:
  /// Reads nothing yet.
  explicit Journal(const std::filesystem::path& project);

  /// Reads what was appended since. A file that was replaced is read anew; none is an empty journal; a last line
  /// without its end is not read. Errors name file and line; all before that line is kept.
  Result<> refresh();

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] const EditHistory& history() const { return history_; }
  [[nodiscard]] std::uint64_t number() const { return history_.number(); }  ///< of the last entry

  /// What shall be appended, seen everything that was before; nothing: nothing is. Undo and redo come alone.
  using Make = std::function<Result<std::vector<NewEdit>>(const EditHistory& history)>;
  /// Appends, under the lock, with one write that is on the disk when this returns: all of it or nothing. A last line
  /// that a killed program left without its end is cut off before. Returns the number of the last entry. Errors: those
  /// of refresh() and of `make`; nothing to undo or redo; the lock cannot be had; the disk is full.
  Result<std::uint64_t> append(const Make& make);

 private:
  Result<> read_on(int descriptor);
  Result<> take(std::string_view line);
  void forget();

  std::filesystem::path file_;
  std::uint64_t device_ = 0, inode_ = 0, position_ = 0;  ///< of the file read, and behind its last whole line
  EditHistory history_;
};

}  // namespace collinea
