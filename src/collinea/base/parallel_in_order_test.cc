// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/parallel_in_order.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

namespace collinea {
namespace {

// Every seventh takes longer than the others.
void linger(std::size_t i) { std::this_thread::sleep_for(std::chrono::microseconds(i % 7 == 0 ? 900 : 30)); }

TEST(ParallelInOrder, WhatIsMadeIsTakenInOrderAndNeverByTwoAtATime) {
  for (const int threads : {1, 2, 5}) {
    std::vector<std::size_t> taken;
    std::atomic<int> takers = 0, exist = 0, most = 0;
    const auto made = parallel_in_order(
        {.threads = threads}, 300,
        [&](std::size_t i) -> Result<std::unique_ptr<std::size_t>> {
          for (int now = ++exist, before = most; now > before && !most.compare_exchange_weak(before, now);) continue;
          linger(i);
          return std::make_unique<std::size_t>(i * i);
        },
        [&](std::size_t i, std::unique_ptr<std::size_t> square) -> Result<> {
          EXPECT_EQ(++takers, 1);
          EXPECT_EQ(*square, i * i);
          taken.push_back(i);
          --takers, --exist;
          return {};
        });
    EXPECT_TRUE(made);
    ASSERT_EQ(taken.size(), 300u);
    for (std::size_t i = 0; i < taken.size(); ++i) EXPECT_EQ(taken[i], i);
    EXPECT_LE(most, 2 * threads);
    if (threads > 1) {
      EXPECT_GT(most, 1);
    }
  }
}

TEST(ParallelInOrder, EndsWithTheFirstErrorInOrder) {
  for (const int threads : {1, 4}) {
    std::size_t taken = 0;
    const auto take = [&](std::size_t, int) -> Result<> {
      ++taken;
      return {};
    };
    const auto made = parallel_in_order(
        {.threads = threads}, 100,
        [&](std::size_t i) -> Result<int> {
          if (i == 20) linger(0);
          if (i == 20 || i == 21) return fail(Errc::kBadInput, std::to_string(i));
          return 1;
        },
        take);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().message, "20");
    EXPECT_EQ(taken, 20u);
    const auto full = parallel_in_order(
        {.threads = threads}, 100, [](std::size_t i) -> Result<std::size_t> { return i; },
        [](std::size_t, std::size_t i) -> Result<> {
          if (i == 30) return fail(Errc::kBadInput, "full");
          return {};
        });
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().message, "full");
  }
}

TEST(ParallelInOrder, AnExceptionReachesTheCallerAlthoughOthersWaitForTheItem) {
  const auto run = [](int threads) {
    (void)parallel_in_order(
        {.threads = threads}, 100,
        [](std::size_t i) -> Result<int> {
          if (i == 17) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
            throw std::runtime_error("seventeen");
          }
          return 1;
        },
        [](std::size_t, int) -> Result<> { return {}; });
  };
  for (const int threads : {1, 3}) EXPECT_THROW(run(threads), std::runtime_error);
}

TEST(ParallelInOrder, StopsWhenAsked) {
  for (const int threads : {1, 3}) {
    std::stop_source source;
    std::size_t taken = 0;
    const auto made = parallel_in_order(
        {.stop = source.get_token(), .threads = threads}, 100'000,
        [](std::size_t i) -> Result<std::size_t> { return i; },
        [&](std::size_t, std::size_t) -> Result<> {
          if (++taken == 10) source.request_stop();
          return {};
        });
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, Errc::kCancelled);
    EXPECT_LT(taken, 100u);
  }
}

}  // namespace
}  // namespace collinea
