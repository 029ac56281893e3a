// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace collinea {
namespace {

TEST(ParallelFor, EveryItemIsDoneOnce) {
  for (const int threads : {1, 2, 5}) {
    std::vector<int> done(1000, 0);
    parallel_for({.threads = threads}, done.size(), [&](std::size_t i) { ++done[i]; });
    EXPECT_EQ(done, std::vector<int>(1000, 1));
  }
}

TEST(ParallelFor, AnExceptionReachesTheCaller) {
  EXPECT_THROW(parallel_for({.threads = 3}, 100,
                            [](std::size_t i) {
                              if (i == 17) throw std::runtime_error("seventeen");
                            }),
               std::runtime_error);
}

TEST(ParallelFor, StopsWhenAsked) {
  std::stop_source source;
  std::atomic<int> done = 0;
  parallel_for({.stop = source.get_token(), .threads = 2}, 100'000, [&](std::size_t) {
    if (++done == 10) source.request_stop();
  });
  EXPECT_LT(done, 100);
}

}  // namespace
}  // namespace collinea
