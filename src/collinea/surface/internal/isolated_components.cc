// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/isolated_components.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "collinea/math/median.h"

namespace collinea {
namespace {

static_assert((IsolatedComponents::kBlock & (IsolatedComponents::kBlock - 1)) == 0);

constexpr std::uint64_t kShare = 100;  // a part with less than 1 / kShare of the largest one's points is small
constexpr double kAlmostAll = 0.9;
constexpr int kFarthestBlocks = 64;      // farther away nothing tells anything of an isolated component
constexpr int kAroundBlocks = 16;        // beyond the nearest of what is around
constexpr double kLowest = 0.05;         // quantile of the heights around; 1 - kLowest of the component's own
constexpr double kShallowestCells = 10;  // what is less deep may be rough ground

}  // namespace

IsolatedComponents::BlockIndex IsolatedComponents::index_of(const GridPoint& point) {
  return {floor_div(std::int64_t(std::floor(point.row)), kBlock),
          floor_div(std::int64_t(std::floor(point.column)), kBlock)};
}

std::size_t IsolatedComponents::index_in_square(const BlockIndex& index) {
  return std::size_t((index.first & (kSquare - 1)) * kSquare + (index.second & (kSquare - 1)));
}

const IsolatedComponents::Block* IsolatedComponents::block_at(const BlockIndex& index) const {
  const auto square = squares_.find({floor_div(index.first, kSquare), floor_div(index.second, kSquare)});
  if (square == squares_.end()) return nullptr;
  const Block& block = square->second[index_in_square(index)];
  return block.points == 0 ? nullptr : &block;
}

IsolatedComponents::Block* IsolatedComponents::block_at(const BlockIndex& index) {
  return const_cast<Block*>(std::as_const(*this).block_at(index));
}

template <class Visit>
void IsolatedComponents::each_block(Visit&& visit) {
  for (auto& [corner, square] : squares_)
    for (std::size_t i = 0; i < square.size(); ++i)
      if (square[i].points > 0)
        visit(BlockIndex{corner.first * kSquare + std::int64_t(i) / kSquare,
                         corner.second * kSquare + std::int64_t(i) % kSquare},
              square[i]);
}

void IsolatedComponents::add(std::span<const GridPoint> points) {
  for (const GridPoint& point : points) {
    const BlockIndex index = index_of(point);
    Block& block =
        squares_[{floor_div(index.first, kSquare), floor_div(index.second, kSquare)}][index_in_square(index)];
    ++block.points;
    block.of_two += point.images == 2;
    block.sum_m += point.height_m;
    const auto column = std::uint8_t(std::int64_t(std::floor(point.column)) & (kBlock - 1)),
               row = std::uint8_t(std::int64_t(std::floor(point.row)) & (kBlock - 1));
    block.west = std::min(block.west, column), block.east = std::max(block.east, column);
    block.north = std::min(block.north, row), block.south = std::max(block.south, row);
  }
}

std::vector<IsolatedComponents::Part> IsolatedComponents::parts() {
  std::vector<Part> parts;
  each_block([&](const BlockIndex& start, Block& first) {
    if (first.part >= 0 || first.points < kFewest) return;
    Part part{{start}, first.points, first.of_two};
    first.part = int(parts.size());
    for (std::size_t next = 0; next < part.blocks.size(); ++next)
      for (std::int64_t dy = -1; dy <= 1; ++dy)
        for (std::int64_t dx = -1; dx <= 1; ++dx) {
          const BlockIndex index{part.blocks[next].first + dy, part.blocks[next].second + dx};
          Block* const block = block_at(index);
          if (!block || block->part >= 0 || block->points < kFewest) continue;
          block->part = int(parts.size());
          part.blocks.push_back(index);
          part.points += block->points;
          part.of_two += block->of_two;
        }
    parts.push_back(std::move(part));
  });
  return parts;
}

bool IsolatedComponents::is_sunken(const Part& part, const std::vector<Part>& parts, double cell_m) const {
  std::int64_t top = std::numeric_limits<std::int64_t>::max(), bottom = -top, left = top, right = bottom;
  std::vector<double> own;
  for (const BlockIndex& index : part.blocks) {
    top = std::min(top, index.first), bottom = std::max(bottom, index.first);
    left = std::min(left, index.second), right = std::max(right, index.second);
    own.push_back(block_at(index)->mean_m());
  }
  // blocks of larger parts by their distance from the component's rectangle
  std::vector<std::pair<std::int64_t, double>> around;
  std::int64_t nearest = kFarthestBlocks;
  for (std::int64_t row = top - kFarthestBlocks; row <= bottom + kFarthestBlocks; ++row)
    for (std::int64_t column = left - kFarthestBlocks; column <= right + kFarthestBlocks; ++column) {
      const Block* const block = block_at({row, column});
      if (!block || block->part < 0 || block->removed || parts[std::size_t(block->part)].points <= part.points)
        continue;
      const std::int64_t away = std::max({left - column, column - right, top - row, row - bottom, std::int64_t{1}});
      nearest = std::min(nearest, away);
      around.emplace_back(away, block->mean_m());
    }
  std::vector<double> heights;
  for (const auto& [away, height_m] : around)
    if (away <= nearest + kAroundBlocks) heights.push_back(height_m);
  if (heights.empty()) return false;
  const double deep_m = quantile(heights, kLowest) - quantile(own, 1 - kLowest);
  return deep_m > std::max(kShallowestCells, double(nearest) * kBlock) * cell_m;
}

void IsolatedComponents::mark_isolated_components(const std::vector<Part>& all, double cell_m) {
  std::vector<const Part*> by_size;
  for (const Part& part : all) by_size.push_back(&part);
  // the largest first: what has gone says nothing of smaller ones
  std::stable_sort(by_size.begin(), by_size.end(), [](const Part* a, const Part* b) { return a->points > b->points; });
  if (all.empty()) return;
  const Part& largest = *by_size.front();
  for (const Part* candidate : by_size) {
    const Part& part = *candidate;
    if (part.points * kShare >= largest.points) continue;
    const bool loose = part.share_of_two() > kAlmostAll && largest.share_of_two() < 0.5;
    if (!loose && !is_sunken(part, all, cell_m)) continue;
    for (const BlockIndex& index : part.blocks)  // with the thin rim around them
      for (std::int64_t dy = -1; dy <= 1; ++dy)
        for (std::int64_t dx = -1; dx <= 1; ++dx) {
          Block* const block = block_at({index.first + dy, index.second + dx});
          if (block && (block->part < 0 || (dx == 0 && dy == 0))) block->removed = 1;
        }
  }
}

std::uint64_t IsolatedComponents::keep_removed() {
  constexpr std::int64_t kFar = std::numeric_limits<std::int64_t>::max();
  bounds_ = {kFar, kFar, -kFar, -kFar};
  std::uint64_t points = 0;
  each_block([&](const BlockIndex& index, const Block& block) {
    if (block.removed) {
      removed_.insert(index);
      points += block.points;
      return;
    }
    const std::int64_t row = index.first * kBlock, column = index.second * kBlock;
    bounds_.west = std::min(bounds_.west, column + block.west);
    bounds_.east = std::max(bounds_.east, column + block.east);
    bounds_.north = std::min(bounds_.north, row + block.north);
    bounds_.south = std::max(bounds_.south, row + block.south);
  });
  squares_.clear();
  return points;
}

std::uint64_t IsolatedComponents::find(double cell_m) {
  mark_isolated_components(parts(), cell_m);
  return keep_removed();
}

bool IsolatedComponents::holds(const GridPoint& point) const {
  return !removed_.empty() && removed_.contains(index_of(point));
}

void IsolatedComponents::forget(const CellWindow& window) {
  for (std::int64_t row = floor_div(window.row, kBlock); row * kBlock < window.row + window.height; ++row)
    for (std::int64_t column = floor_div(window.column, kBlock); column * kBlock < window.column + window.width;
         ++column)
      if (Block* const block = block_at({row, column})) *block = Block{};
}

}  // namespace collinea
