// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/ordering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {
namespace {

// Images on a grid that share points with all images up to two rows and columns away.
struct Grid {
  Covisibility graph;
  std::vector<Eigen::Vector3d> centres;
};

Grid grid(int rows, int columns) {
  Grid result;
  for (int i = 0; i < rows * columns; ++i) {
    const int row = i / columns, column = i % columns;
    auto& neighbours = result.graph.emplace_back();
    for (int r = std::max(0, row - 2); r <= std::min(rows - 1, row + 2); ++r)
      for (int c = std::max(0, column - 2); c <= std::min(columns - 1, column + 2); ++c)
        if (r != row || c != column) neighbours.push_back(r * columns + c);
    result.centres.emplace_back(column, row, 0);
  }
  return result;
}

// Products of tiles that Cholesky's factor takes.
double work(const Covisibility& graph, const std::vector<int>& number, int per_tile = kPosesOfTile) {
  TilePattern pattern((graph.size() + per_tile - 1) / per_tile);
  for (std::size_t i = 0; i < graph.size(); ++i)
    for (const int other : graph[i])
      pattern[std::max(number[i], number[other]) / per_tile].push_back(std::min(number[i], number[other]) / per_tile);
  double products = 0;
  for (const auto& below : factor_columns(pattern)) products += std::pow(below.size() + 1.0, 2);
  return products;
}

double work_in_order(const Grid& g) { return work(g.graph, elimination_order(g.graph, g.centres, kPosesOfTile)); }

std::vector<int> in_rows(std::size_t count) {
  std::vector<int> number(count);
  for (std::size_t i = 0; i < count; ++i) number[i] = static_cast<int>(i);
  return number;
}

TEST(Ordering, GivesEveryImageANumberOfItsOwn) {
  for (const auto& [rows, columns] : {std::pair(1, 1), {3, 5}, {1, 100}, {17, 19}}) {
    const Grid g = grid(rows, columns);
    std::vector<int> number = elimination_order(g.graph, g.centres, kPosesOfTile);
    std::sort(number.begin(), number.end());
    EXPECT_EQ(number, in_rows(g.graph.size()));
  }
}

// Rows one after the other are a band: the work grows with the square of the number of images. Nested dissection
// takes its 1.5th power: less than 2^1.8 times as much for twice the images, and less than the band at 70 x 70.
TEST(Ordering, WorkGrowsSlowerThanThatOfABand) {
  const Grid small = grid(50, 50), large = grid(70, 71);
  const double work_of_large = work_in_order(large);
  EXPECT_LT(work_of_large, std::pow(2, 1.8) * work_in_order(small));
  EXPECT_LT(work_of_large, 0.8 * work(large.graph, in_rows(large.graph.size())));
}

// With a tile an image the work would be in numbers, without zeros: a product of tiles of four has 64 of its products.
TEST(Ordering, TilesHoldFewZeros) {
  const Grid g = grid(70, 71);
  const std::vector<int> number = elimination_order(g.graph, g.centres, kPosesOfTile);
  EXPECT_LT(work(g.graph, number), 1.4 * work(g.graph, number, 1) / std::pow(kPosesOfTile, 3));
}

TEST(Ordering, NarrowStripsAreABand) {
  const Grid g = grid(3, 200);
  std::vector<int> columns(600);
  for (int i = 0; i < 600; ++i) columns[static_cast<std::size_t>(i)] = i % 200 * 3 + i / 200;
  EXPECT_LE(work_in_order(g), 1.3 * work(g.graph, columns));
}

TEST(Ordering, DoesWithoutCentres) {
  Grid g = grid(40, 40);
  const double with = work_in_order(g);
  for (auto& centre : g.centres) centre.setZero();
  EXPECT_LT(work_in_order(g), 1.6 * with);
  for (auto& centre : g.centres) centre.setConstant(std::nan(""));
  EXPECT_LT(work_in_order(g), 1.6 * with);
}

TEST(Ordering, PartsThatDoNotHangTogetherKeepApart) {
  const Grid one = grid(20, 20);
  Grid both = one;
  for (const auto& neighbours : one.graph) {
    auto& moved = both.graph.emplace_back(neighbours);
    for (int& image : moved) image += 400;
  }
  both.centres.insert(both.centres.end(), one.centres.begin(), one.centres.end());  // at the same positions
  EXPECT_LT(work_in_order(both), 2.5 * work_in_order(one));
}

TEST(Ordering, WhereEveryImageSeesAllThereIsNothingToCut) {
  Covisibility all(60);
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 60; ++k)
      if (i != k) all[static_cast<std::size_t>(i)].push_back(k);
  std::vector<int> number = elimination_order(all, std::vector<Eigen::Vector3d>(60, {1, 2, 3}), kPosesOfTile);
  std::sort(number.begin(), number.end());
  EXPECT_EQ(number, in_rows(60));
}

}  // namespace
}  // namespace collinea::bundle
