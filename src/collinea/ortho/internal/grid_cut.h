// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace collinea {

/// The smallest cut through a grid of cells with four neighbours each: divides the cells into two sides such that the
/// sum of what is cut (edges between neighbours, and the pull of a cell to the side it is not on) is least. Exact, by
/// the largest flow (Boykov and Kolmogorov 2004: two trees that are kept from one augmenting path to the next).
/// Capacities are whole numbers; their sum at a cell must stay below 2^30.
class GridCut {
 public:
  enum Direction : std::uint8_t { kEast, kSouth, kWest, kNorth };

  GridCut(int width, int height);

  /// What it costs to have the cell on the first side, and on the second. May be added to.
  void add_terminal(int x, int y, int first, int second) { node(x, y).excess += second - first; }
  /// What it costs when the cell is on the first side and its neighbour (kEast or kSouth) on the second, and the other
  /// way round.
  void add_edge(int x, int y, Direction to, int forward, int backward);

  void solve();
  /// After solve(). Cells that may be on either side at the same price are on the first.
  [[nodiscard]] bool on_first_side(int x, int y) const { return nodes_[index(x, y)].tree != kSecond; }

 private:
  enum Tree : std::uint8_t { kFree, kFirst, kSecond };
  // What a parent is: a direction, or one of these.
  static constexpr std::uint8_t kTerminal = 4, kOrphan = 5, kNone = 6;
  struct Node {
    int residual[4] = {0, 0, 0, 0};
    int excess = 0;  // > 0: left to take from the first side, < 0: left to give to the second
    int seen = 0, distance = 0;
    Tree tree = kFree;
    std::uint8_t parent = kNone;
    bool active = false;
  };
  struct Bridge {  // an edge from the first tree to the second
    std::size_t from = 0;
    std::uint8_t to = 0;
  };

  // One cell of margin all around spares looking for the border.
  [[nodiscard]] std::size_t index(int x, int y) const {
    return std::size_t(y + 1) * std::size_t(width_ + 2) + std::size_t(x + 1);
  }
  [[nodiscard]] Node& node(int x, int y) { return nodes_[index(x, y)]; }
  [[nodiscard]] std::size_t neighbour(std::size_t i, std::uint8_t to) const { return i + std::size_t(step_[to]); }
  static std::uint8_t opposite(std::uint8_t to) { return to ^ 2; }
  // What can still flow over the edge from a cell of this tree away from its root.
  [[nodiscard]] int outward(Tree tree, std::size_t i, std::uint8_t to) const {
    return tree == kFirst ? nodes_[i].residual[to] : nodes_[neighbour(i, to)].residual[opposite(to)];
  }
  void activate(std::size_t i);
  bool grow(std::size_t i, Bridge& bridge);
  void augment(const Bridge& bridge);
  int narrowest(const Bridge& bridge) const;
  void push_along(Tree tree, std::size_t i, int flow);
  void adopt();
  int distance_to_root(std::size_t i);
  void mark_path(std::size_t i, int distance);
  void find_parent(std::size_t orphan);

  int width_;
  std::ptrdiff_t step_[4];
  std::vector<Node> nodes_;
  std::vector<std::size_t> queue_, orphans_;
  std::size_t queue_front_ = 0;
  int time_ = 0;
};

}  // namespace collinea
