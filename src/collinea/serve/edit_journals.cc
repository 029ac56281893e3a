// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/edit_journals.h"

#include "collinea/base/file.h"
#include "collinea/edit/work_in_force.h"
#include "collinea/serve/edits_json.h"

namespace collinea {
namespace {

constexpr std::size_t kMostEntries = 2000;               // of an answer
constexpr std::chrono::milliseconds kBetweenLooks(200);  // at files
constexpr std::chrono::seconds kBetweenListings(2);      // of projects
constexpr std::chrono::milliseconds kPatience(20);       // with a database, of who looks at all projects

}  // namespace

std::shared_ptr<EditJournals::Kept> EditJournals::kept(const ServedProject& project) {
  const std::lock_guard lock(mutex_);
  auto& one = kept_[project.id];
  if (!one) one = std::make_shared<Kept>(project.folder);
  return one;
}

Result<std::string> EditJournals::edits(const ServedProject& project, std::uint64_t since) {
  const auto one = kept(project);
  const std::lock_guard lock(one->mutex);
  COLLINEA_TRY(one->journal.refresh());
  return edits_json(one->journal.history(), since, kMostEntries);
}

Result<std::vector<CloudRegion>> EditJournals::cloud_regions(const ServedProject& project) {
  const auto one = kept(project);
  const std::lock_guard lock(one->mutex);
  COLLINEA_TRY(one->journal.refresh());
  return cloud_regions_in_force(one->journal.history());
}

Result<EditsMade> EditJournals::make(const ServedProject& project, const Edit& edit) {
  const auto one = kept(project);
  const std::lock_guard lock(one->mutex);
  COLLINEA_TRY(EditsMade made, make_edits(project.folder, one->journal, {&edit, 1}));
  one->is_waiting = made.waiting.has_value();
  return made;
}

// A journal that cannot be read shows when somebody asks for it.
void EditJournals::look(std::span<const std::filesystem::path> roots) {
  const auto now = Clock::now();
  if (now - looked_ < kBetweenLooks) return;
  looked_ = now;
  if (now - listed_ > kBetweenListings) {
    projects_ = find_projects(roots);
    listed_ = now;
  }
  for (const ServedProject& project : projects_) {
    auto& one = kept_[project.id];
    if (!one && !is_there(Journal(project.folder).file())) continue;
    if (!one) one = std::make_shared<Kept>(project.folder);
    const std::unique_lock lock(one->mutex, std::try_to_lock);
    if (!lock || !one->journal.refresh()) continue;  // somebody edits: the next look sees it
    Seen& seen = seen_[project.id];
    if (seen.number != one->journal.number()) {
      seen = {one->journal.number(), ++last_change_};
    }
    if (!one->is_waiting) continue;
    auto store = ProjectStore::open(project.folder, kPatience);
    one->is_waiting = !store || !apply_edits(*store, one->journal);
  }
}

JournalChanges EditJournals::since(std::uint64_t change, std::span<const std::filesystem::path> roots) {
  const std::lock_guard lock(mutex_);
  look(roots);
  JournalChanges changes{last_change_, {}};
  for (const auto& [project, seen] : seen_)
    if (seen.change > change) changes.grown.push_back({project, seen.number});
  return changes;
}

}  // namespace collinea
