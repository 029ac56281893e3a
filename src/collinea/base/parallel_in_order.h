// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <map>
#include <mutex>
#include <type_traits>
#include <utility>

#include "collinea/base/parallel.h"
#include "collinea/base/result.h"

namespace collinea {

/// Calls make(i), a Result of something, for every i in [0, count) on run.threads threads, and take(i, what was made)
/// in the order of i, one call at a time, on any of the threads: whoever has made the next one takes it while the
/// others go on. At most 2 run.threads of them exist at a time, made or in the making. Ends with the first error in the
/// order of i, of make or take; errors besides these: cancelled. The first exception is thrown again here.
template <class Make, class Take>
Result<> parallel_in_order(const Run& run, std::size_t count, const Make& make, const Take& take) {
  using Made = std::invoke_result_t<const Make&, std::size_t>;
  const auto most_waiting = static_cast<std::size_t>(run.threads > 1 ? run.threads : 1);
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::size_t, Made> waiting;  // made, and not yet taken
  std::size_t next = 0;                 // to be taken
  bool taking = false, ended = false;
  Result<> outcome;

  const auto take_those_whose_turn_it_is = [&](std::unique_lock<std::mutex>& lock) {
    if (taking) return;  // by who will look for ours, too
    taking = true;
    while (!ended && !waiting.empty() && waiting.begin()->first == next) {
      Made made = std::move(waiting.begin()->second);
      waiting.erase(waiting.begin());
      lock.unlock();
      Result<> taken = made ? take(next, *std::move(made)) : Result<>(tl::unexpected(std::move(made).error()));
      lock.lock();
      ++next;
      if (!taken) outcome = std::move(taken), ended = true;
      changed.notify_all();
    }
    taking = false;
  };
  const auto end = [&] {
    const std::lock_guard lock(mutex);
    ended = true;
    changed.notify_all();
  };
  parallel_for(run, count, [&](std::size_t i) {
    {
      const std::lock_guard lock(mutex);
      if (ended) return;
    }
    try {
      Made made = make(i);
      std::unique_lock lock(mutex);
      waiting.emplace(i, std::move(made));
      take_those_whose_turn_it_is(lock);
      // What comes next is still being made by another thread: items are handed out in order.
      changed.wait(lock, [&] { return ended || waiting.size() < most_waiting; });
    } catch (...) {
      end();  // nobody need wait for this one
      throw;
    }
  });
  if (outcome && run.stopped()) return fail(Errc::kCancelled, "cancelled");
  return outcome;
}

}  // namespace collinea
