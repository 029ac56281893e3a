// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>

#include "collinea/base/parallel.h"

namespace collinea {
namespace {

// Work on the units of a list that remain.
struct Working {
  const Run& run;
  const UnitList& list;
  const UnitJob& job;
  Run one_thread;
  UnitProgress progress;
  UnitsDone done;
  std::map<std::size_t, Error> ended_by;  // errors that end the list, by unit
  std::atomic<bool> ended = false;
  std::mutex mutex;

  void one(std::size_t unit) {
    if (ended) return;
    Result<UnitWorked> worked = job.work(unit, one_thread);
    if (worked && !worked->skipped_because) {
      done.ends[unit] = UnitEnd::kMade;
    } else if (worked) {
      done.ends[unit] = UnitEnd::kSkipped;
      const std::lock_guard lock(mutex);
      done.skipped_because.emplace(unit, *std::move(worked->skipped_because));
    } else {
      ended = true;
      const std::lock_guard lock(mutex);
      ended_by.emplace(unit, std::move(worked).error());
      return;
    }
    progress.finish_one();
  }

  Result<> all(std::span<const std::size_t> units) {
    parallel_for(run, units.size(), [&](std::size_t i) { one(units[i]); });
    const Result<> kept = job.keep ? job.keep() : Result<>{};
    if (!ended_by.empty() && !run.stopped()) {
      auto& [unit, error] = *ended_by.begin();
      return tl::unexpected(std::move(error).within(name_of(list.units[unit])));
    }
    if (!kept) return kept;
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    return {};
  }
};

Run one_thread_of(const Run& run) {
  Run one = run;
  one.threads = 1;
  one.progress = nullptr;
  return one;
}

}  // namespace

std::string name_of(const Unit& unit) {
  const std::string_view kind = word_of(unit.kind);
  if (unit.kind == UnitKind::kPair) return fmt::format("{} {}-{}", kind, unit.first, unit.second);
  if (unit.kind == UnitKind::kTile || unit.kind == UnitKind::kWindow)
    return fmt::format("{} {},{}", kind, unit.first, unit.second);
  return fmt::format("{} {}", kind, unit.first);
}

std::vector<Unit> tiles_over(std::int64_t width, std::int64_t height, std::int64_t tile_width,
                             std::int64_t tile_height) {
  std::vector<Unit> tiles;
  for (std::int64_t row = 0; row * tile_height < height; ++row)
    for (std::int64_t column = 0; column * tile_width < width; ++column) tiles.push_back(Unit::tile(column, row));
  return tiles;
}

UnitProgress::UnitProgress(const Run& run, const UnitList& list, std::size_t remaining)
    : run_(run), list_(list), remaining_(remaining) {
  if (remaining == 0) run_.report(list_.stage, list_.end);
}

void UnitProgress::finish_one() {
  const std::lock_guard lock(mutex_);  // also while it is reported: a later count never comes first
  ++finished_;
  const double part = double(finished_) / double(remaining_);
  run_.report(list_.stage, finished_ == remaining_ ? list_.end : list_.begin + (list_.end - list_.begin) * part);
}

std::size_t UnitsDone::count(UnitEnd end) const {
  return static_cast<std::size_t>(std::count(ends.begin(), ends.end(), end));
}

Result<UnitsDone> run_units(const Run& run, const UnitList& list, const UnitJob& job) {
  UnitsDone done;
  done.ends.resize(list.units.size(), UnitEnd::kNotDone);
  std::vector<std::size_t> remaining;
  for (std::size_t i = 0; i < list.units.size(); ++i) {
    if (job.is_done && job.is_done(i))
      done.ends[i] = UnitEnd::kKept;
    else
      remaining.push_back(i);
  }
  Working working{run, list, job, one_thread_of(run), UnitProgress(run, list, remaining.size()), std::move(done)};
  const std::size_t size = std::max<std::size_t>(1, job.batch ? job.batch : remaining.size());
  for (std::size_t start = 0; start < remaining.size(); start += size)
    COLLINEA_TRY(working.all(std::span(remaining).subspan(start, std::min(size, remaining.size() - start))));
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  return std::move(working.done);
}

void say_kept(const Run& run, std::string_view stage, UnitKind kind, std::size_t kept, std::size_t all) {
  if (kept > 0) run.say(fmt::format("{}: {} of {} {}s kept from before", stage, kept, all, word_of(kind)));
}

void say_kept(const Run& run, const UnitList& list, const UnitsDone& done) {
  if (!list.units.empty())
    say_kept(run, list.stage, list.units.front().kind, done.count(UnitEnd::kKept), list.units.size());
}

Result<> run_units_one_by_one(const Run& run, const UnitList& list, const std::function<Result<>(const Unit&)>& work) {
  UnitProgress progress(run, list, list.units.size());
  for (const Unit& unit : list.units) {
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    COLLINEA_TRY(work(unit));
    progress.finish_one();
  }
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  return {};
}

}  // namespace collinea
