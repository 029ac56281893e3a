// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/grid_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "collinea/math/random.h"

namespace collinea {
namespace {

// A made-up problem small enough to try all cuts.
struct Problem {
  int width, height;
  std::vector<int> first, second;      // pull of each cell
  std::vector<int> east[2], south[2];  // forward, backward

  Problem(int w, int h, Random& random) : width(w), height(h) {
    const auto some = [&](int most) { return int(random.uniform(0, most + 0.999)); };
    for (int i = 0; i < w * h; ++i) {
      first.push_back(some(9)), second.push_back(some(9));
      for (auto* edges : {&east[0], &east[1], &south[0], &south[1]}) edges->push_back(some(6));
    }
  }
  [[nodiscard]] int price(const std::vector<bool>& on_first) const {
    int sum = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto i = std::size_t(y * width + x);
        sum += on_first[i] ? first[i] : second[i];
        const auto side = [&](const std::vector<int>* edges, std::size_t j) {
          if (on_first[i] != on_first[j]) sum += edges[on_first[i] ? 0 : 1][i];
        };
        if (x + 1 < width) side(east, i + 1);
        if (y + 1 < height) side(south, i + std::size_t(width));
      }
    }
    return sum;
  }
  [[nodiscard]] int least() const {
    int best = std::numeric_limits<int>::max();
    for (unsigned bits = 0; bits < 1u << (width * height); ++bits) {
      std::vector<bool> on_first;
      for (int i = 0; i < width * height; ++i) on_first.push_back(bits >> i & 1);
      best = std::min(best, price(on_first));
    }
    return best;
  }
  [[nodiscard]] GridCut cut() const {
    GridCut cut(width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto i = std::size_t(y * width + x);
        cut.add_terminal(x, y, first[i], second[i]);
        if (x + 1 < width) cut.add_edge(x, y, GridCut::kEast, east[0][i], east[1][i]);
        if (y + 1 < height) cut.add_edge(x, y, GridCut::kSouth, south[0][i], south[1][i]);
      }
    }
    return cut;
  }
};

TEST(GridCut, IsTheLeastOfAllCuts) {
  Random random(3);
  for (int trial = 0; trial < 300; ++trial) {
    const Problem problem(1 + trial % 4, 1 + trial % 3, random);
    GridCut cut = problem.cut();
    cut.solve();
    std::vector<bool> on_first;
    for (int y = 0; y < problem.height; ++y)
      for (int x = 0; x < problem.width; ++x) on_first.push_back(cut.on_first_side(x, y));
    EXPECT_EQ(problem.price(on_first), problem.least()) << trial;
  }
}

// A cut that is known to be the least by its size: 40 pulls to the left against 40 to the right, and one weak column.
TEST(GridCut, RunsThroughTheWeakColumnOfALargeGrid) {
  constexpr int kWidth = 90, kHeight = 40, kWeak = 57;
  GridCut cut(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    cut.add_terminal(0, y, 0, 1000);
    cut.add_terminal(kWidth - 1, y, 1000, 0);
    for (int x = 0; x < kWidth; ++x) {
      if (x + 1 < kWidth) cut.add_edge(x, y, GridCut::kEast, x == kWeak ? 4 : 5, x == kWeak ? 4 : 5);
      if (y + 1 < kHeight) cut.add_edge(x, y, GridCut::kSouth, 5, 5);
    }
  }
  cut.solve();
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) ASSERT_EQ(cut.on_first_side(x, y), x <= kWeak) << x << ' ' << y;
}

}  // namespace
}  // namespace collinea
