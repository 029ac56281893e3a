// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace collinea {

void parallel_for(const Run& run, std::size_t count, const std::function<void(std::size_t)>& work) {
  const auto threads = std::min<std::size_t>(static_cast<std::size_t>(std::max(1, run.threads)), count);
  if (threads <= 1) {
    for (std::size_t i = 0; i < count && !run.stopped(); ++i) work(i);
    return;
  }
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr first_failure;
  const auto take_items = [&] {
    for (;;) {
      if (run.stopped()) return;  // before an item is taken: others may wait for what was taken
      const std::size_t i = next.fetch_add(1);
      if (i >= count) return;
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!first_failure) first_failure = std::current_exception();
        next.store(count);
        return;
      }
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (std::size_t t = 1; t < threads; ++t) helpers.emplace_back(take_items);
    take_items();
  }
  if (first_failure) std::rethrow_exception(first_failure);
}

}  // namespace collinea
