// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "collinea/edit/edited_work.h"
#include "collinea/edit/make_edits.h"
#include "collinea/serve/project_files.h"

namespace collinea {

/// A journal that grew.
struct GrownJournal {
  std::string project;       ///< its id
  std::uint64_t number = 0;  ///< of its last entry
};

/// Journals that grew behind some change, and the number of the last change.
struct JournalChanges {
  std::uint64_t change = 0;
  std::vector<GrownJournal> grown;
};

/// The journals of the projects of a server. Each is read once, and then only what was appended, by whomever. May be
/// used from several threads at once; edits of one project come one after the other.
class EditJournals {
 public:
  /// As edits_json() has it, read anew where the file grew.
  [[nodiscard]] Result<std::string> edits(const ServedProject& project, std::uint64_t since);
  /// The regions of the cloud that are in force.
  [[nodiscard]] Result<std::vector<CloudRegion>> cloud_regions(const ServedProject& project);
  /// The number of the last entry.
  [[nodiscard]] Result<EditsMade> make(const ServedProject& project, const Edit& edit);
  /// What grew behind `change`, in whichever program; everything that has entries behind 0. Looks at the files at most
  /// a few times a second, however many ask. What waits for a database is tried again.
  [[nodiscard]] JournalChanges since(std::uint64_t change, std::span<const std::filesystem::path> roots);

 private:
  using Clock = std::chrono::steady_clock;
  struct Kept {
    explicit Kept(const std::filesystem::path& project) : journal(project) {}
    std::mutex mutex;
    Journal journal;          // below: of the mutex
    bool is_waiting = false;  // entries are not in the database yet
  };
  struct Seen {
    std::uint64_t number = 0, change = 0;
  };

  std::shared_ptr<Kept> kept(const ServedProject& project);
  void look(std::span<const std::filesystem::path> roots);

  std::mutex mutex_;  // of all below
  std::map<std::string, std::shared_ptr<Kept>> kept_;
  std::map<std::string, Seen> seen_;
  std::vector<ServedProject> projects_;
  std::uint64_t last_change_ = 0;
  Clock::time_point looked_ = {}, listed_ = {};
};

}  // namespace collinea
