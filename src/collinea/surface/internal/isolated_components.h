// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "collinea/surface/internal/gridding.h"

namespace collinea {

/// Small parts of a cloud that lie apart from the rest, and far below all of it or seen by two images alone: mirror
/// images in water and glass, repeated patterns that several images take for the same wrong position, and what two
/// images make of waves and leaves at the rim of a block. Looked for in blocks of kBlock x kBlock cells.
///
/// A part (blocks with at least kFewest points, 8 neighbours) with less than a hundredth of the points of the largest
/// one goes when
/// - its top lies deeper below the lowest of what is around it than that is away: the ground would have to fall by more
///   than 45 degrees all the way. A courtyard between roofs stays, since there is other ground as low around; so do
///   roofs without ground;
/// - or only two images see it, while more see most of the largest part: a wrong match of two images is the same in
///   both, and there is no surface that it joins.
class IsolatedComponents {
 public:
  static constexpr int kBlock = 16;
  static constexpr int kFewest = 16;

  void add(std::span<const GridPoint> points);
  /// To be called once all points are there; keeps of them only which blocks are isolated. Returns how many points lie
  /// on these.
  std::uint64_t find(double cell_m);
  [[nodiscard]] bool holds(const GridPoint& point) const;
  /// The points of a window, whole blocks of it, are not there any more.
  void forget(const CellWindow& window);
  /// Once isolated components are found: the outermost cells with points that lie on none, all included. There must be
  /// some.
  struct Bounds {
    std::int64_t west, north, east, south;
  };
  [[nodiscard]] const Bounds& bounds() const { return bounds_; }

 private:
  using BlockIndex = std::pair<std::int64_t, std::int64_t>;  // row and column of a block
  struct Block {
    double sum_m = 0;                                                 // of heights
    std::uint32_t points = 0, of_two = 0;                             // the second: seen by two images alone
    std::uint8_t west = kBlock, north = kBlock, east = 0, south = 0;  // cells with points, within the block
    std::int32_t part : 31 = -1;
    std::uint32_t removed : 1 = 0;
    [[nodiscard]] double mean_m() const { return sum_m / double(points); }
  };
  static_assert(sizeof(Block) == 24);
  // There are many blocks: they are kept in squares of kSquare x kSquare, those without points beside the others.
  static constexpr int kSquare = 16;
  using Square = std::array<Block, std::size_t(kSquare) * kSquare>;
  struct Part {
    std::vector<BlockIndex> blocks;
    std::uint64_t points = 0, of_two = 0;
    [[nodiscard]] double share_of_two() const { return double(of_two) / double(points); }
  };
  [[nodiscard]] static BlockIndex index_of(const GridPoint& point);
  [[nodiscard]] static std::size_t index_in_square(const BlockIndex& index);
  [[nodiscard]] const Block* block_at(const BlockIndex& index) const;  // null: no points there
  [[nodiscard]] Block* block_at(const BlockIndex& index);
  template <class Visit>
  void each_block(Visit&& visit);  // that has points: visit(index, block)
  [[nodiscard]] std::vector<Part> parts();
  [[nodiscard]] bool is_sunken(const Part& part, const std::vector<Part>& parts, double cell_m) const;

  void mark_isolated_components(const std::vector<Part>& parts, double cell_m);
  std::uint64_t keep_removed();

  std::map<BlockIndex, Square> squares_;  // by row and column of a square
  std::set<BlockIndex> removed_;
  Bounds bounds_{};
};

}  // namespace collinea
