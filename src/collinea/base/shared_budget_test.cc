// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/shared_budget.h"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include "collinea/base/parallel.h"

namespace collinea {
namespace {

Run run_on(int threads) {
  Run run;
  run.threads = threads;
  return run;
}

TEST(SharedBudget, NeverHoldsMoreThanThereIs) {
  SharedBudget room(100);
  std::atomic<std::size_t> in_use = 0, most = 0, served = 0;
  parallel_for(run_on(4), 2000, [&](std::size_t i) {
    const std::size_t bytes = 20 + 13 * (i % 7);
    const SharedBudget::Part part = room.take(bytes);
    const std::size_t now = in_use += bytes;
    for (std::size_t before = most; now > before && !most.compare_exchange_weak(before, now);) {
    }
    ++served;
    in_use -= bytes;
  });
  EXPECT_EQ(served, 2000u);
  EXPECT_LE(most, 100u);
  EXPECT_LE(room.most_in_use(), 100u);
  EXPECT_GE(room.most_in_use(), 98u);  // the largest part alone
}

TEST(SharedBudget, WhatIsLargerThanAllOfItIsAlone) {
  SharedBudget room(100);
  std::atomic<int> inside = 0, together = 0;
  parallel_for(run_on(4), 500, [&](std::size_t i) {
    const bool large = i % 5 == 0;
    const SharedBudget::Part part = room.take(large ? 1000 : 30);
    const int before = inside += large ? 100 : 1;
    if (before > 100) ++together;
    inside -= large ? 100 : 1;
  });
  EXPECT_EQ(together, 0);
  EXPECT_EQ(room.most_in_use(), 1000u);
}

// Else something large could wait for ever while small ones come and go.
TEST(SharedBudget, IsGivenInTheOrderOfAsking) {
  SharedBudget room(100);
  std::optional<SharedBudget::Part> first(room.take(60));
  std::atomic<bool> large_served = false, small_after_large = false;
  std::jthread large([&] {
    const SharedBudget::Part part = room.take(90);
    large_served = true;
  });
  std::jthread small([&] {
    while (room.waiting() == 0) std::this_thread::yield();
    const SharedBudget::Part part = room.take(20);  // would fit beside the first
    small_after_large = large_served.load();
  });
  while (room.waiting() < 2) std::this_thread::yield();
  EXPECT_FALSE(large_served);
  first.reset();
  large.join();
  small.join();
  EXPECT_TRUE(small_after_large);
}

}  // namespace
}  // namespace collinea
