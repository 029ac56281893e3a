// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "collinea/ortho/internal/grid_cut.h"
#include "collinea/ortho/internal/seam_window.h"
#include "collinea/ortho/internal/view_costs.h"

namespace collinea {
namespace {

using Labels = Raster<std::int16_t>;
constexpr int kBlock = SeamWindow::kBlock;
constexpr int kMostRounds = 3;

struct Box {
  int left, top, right, bottom;
  [[nodiscard]] bool holds(int x, int y) const { return x >= left && x < right && y >= top && y < bottom; }
};

// The blocks in which a view is worth a look, within the cells that may change.
Box box_of(const SeamWindow& window, std::int16_t view, const Box& free) {
  Box box{window.width(), window.height(), 0, 0};
  for (int j = 0; j < window.blocks_down(); ++j) {
    for (int i = 0; i < window.blocks_across(); ++i) {
      if (window.block(i, j).slot_of(view) < 0) continue;
      box.left = std::min(box.left, i * kBlock), box.right = std::max(box.right, (i + 1) * kBlock);
      box.top = std::min(box.top, j * kBlock), box.bottom = std::max(box.bottom, (j + 1) * kBlock);
    }
  }
  return {std::max(box.left, free.left), std::max(box.top, free.top), std::min(box.right, free.right),
          std::min(box.bottom, free.bottom)};
}

// True when a label in the box or beside it has changed after a time.
bool changed_since(const SeamWindow& window, const Box& box, const std::vector<int>& changed_at, int time) {
  for (int j = std::max(0, box.top - 1) / kBlock; j <= std::min(box.bottom, window.height() - 1) / kBlock; ++j)
    for (int i = std::max(0, box.left - 1) / kBlock; i <= std::min(box.right, window.width() - 1) / kBlock; ++i)
      if (changed_at[std::size_t(j * window.blocks_across() + i)] > time) return true;
  return false;
}

// One move: every cell either keeps its view or takes alpha, so that the energy becomes the least.
class Expansion {
 public:
  Expansion(const SeamWindow& window, std::int16_t alpha, const Box& box, Labels& labels)
      : window_(window),
        alpha_(alpha),
        box_(box),
        around_{std::max(0, box.left - 1), std::max(0, box.top - 1), std::min(window.width(), box.right + 1),
                std::min(window.height(), box.bottom + 1)},
        labels_(labels),
        cut_(box.right - box.left, box.bottom - box.top),
        cells_(std::size_t((around_.right - around_.left) * (around_.bottom - around_.top))) {
    for (int y = around_.top; y < around_.bottom; ++y)
      for (int x = around_.left; x < around_.right; ++x) look_at(x, y);
  }

  // Notes the time at the blocks that change.
  bool move(std::vector<int>& changed_at, int time) {
    for (int y = box_.top; y < box_.bottom; ++y)
      for (int x = box_.left; x < box_.right; ++x) add_cell(x, y);
    cut_.solve();
    bool changed = false;
    for (int y = box_.top; y < box_.bottom; ++y) {
      for (int x = box_.left; x < box_.right; ++x) {
        if (!at(x, y).free || cut_.on_first_side(x - box_.left, y - box_.top)) continue;
        labels_.at(x, y) = alpha_;
        changed_at[std::size_t(y / kBlock * window_.blocks_across() + x / kBlock)] = time;
        changed = true;
      }
    }
    return changed;
  }

 private:
  struct Cell {
    const SeamWindow::Choice *own = nullptr, *alpha = nullptr;
    float different = 1;  // the one from the other
    bool free = false;    // to take alpha
  };

  [[nodiscard]] Cell& at(int x, int y) {
    return cells_[std::size_t((y - around_.top) * (around_.right - around_.left) + x - around_.left)];
  }

  void look_at(int x, int y) {
    const std::int16_t own = labels_.at(x, y);
    if (own == kNoView) return;
    Cell& cell = at(x, y);
    cell.own = window_.choice(x, y, own);
    cell.alpha = window_.choice(x, y, alpha_);
    cell.different = own == alpha_ ? 0 : SeamWindow::difference(cell.own, cell.alpha);
    cell.free = box_.holds(x, y) && own != alpha_ && cell.alpha && cell.alpha->price != SeamWindow::kForbidden;
  }

  void add_cell(int x, int y) {
    const Cell& cell = at(x, y);
    if (cell.free) add_price(x, y, cell.own ? cell.own->price : SeamWindow::kForbidden, cell.alpha->price);
    if (x + 1 < window_.width()) add_side(x, y, x + 1, y, GridCut::kEast);
    if (y + 1 < window_.height()) add_side(x, y, x, y + 1, GridCut::kSouth);
    // Sides to what lies before the box belong to no cell of the box.
    if (cell.free && x == box_.left && x > 0) add_to_fixed(x, y, x - 1, y);
    if (cell.free && y == box_.top && y > 0) add_to_fixed(x, y, x, y - 1);
  }

  void add_side(int x, int y, int u, int v, GridCut::Direction to) {
    if (at(x, y).free && at(u, v).free) return add_free_side(x, y, u, v, to);
    if (at(x, y).free) add_to_fixed(x, y, u, v);
    if (at(u, v).free) add_to_fixed(u, v, x, y);
  }

  void add_free_side(int x, int y, int u, int v, GridCut::Direction to) {
    const int both_keep = price_as_is(x, y, u, v);
    const int first_moves = price_if_first_moves(x, y, u, v), second_moves = price_if_first_moves(u, v, x, y);
    add_price(x, y, 0, first_moves - both_keep);
    add_price(u, v, 0, -first_moves);
    // Not negative but for rounding: the price is a metric.
    cut_.add_edge(x - box_.left, y - box_.top, to, std::max(0, second_moves + first_moves - both_keep), 0);
  }

  void add_to_fixed(int x, int y, int u, int v) {
    if (labels_.at(u, v) != kNoView) add_price(x, y, price_as_is(x, y, u, v), price_if_first_moves(x, y, u, v));
  }

  int price_as_is(int x, int y, int u, int v) {
    const std::int16_t p = labels_.at(x, y), q = labels_.at(u, v);
    if (p == q) return 0;
    const float here = SeamWindow::difference(at(x, y).own, window_.choice(x, y, q));
    const float there = SeamWindow::difference(window_.choice(u, v, p), at(u, v).own);
    return window_.seam_price(x, y, u, v, (here + there) / 2);
  }

  // Alpha in the first cell, its own view in the second.
  int price_if_first_moves(int x, int y, int u, int v) {
    const std::int16_t p = labels_.at(x, y), q = labels_.at(u, v);
    if (q == alpha_) return 0;
    const float here = p == q ? at(x, y).different : SeamWindow::difference(at(x, y).alpha, window_.choice(x, y, q));
    return window_.seam_price(x, y, u, v, (here + at(u, v).different) / 2);
  }

  void add_price(int x, int y, int keeps, int takes) {
    constexpr int kMost = 1 << 20;  // more than all sides of a cell together
    cut_.add_terminal(x - box_.left, y - box_.top, std::min(keeps, kMost), std::min(takes, kMost));
  }

  const SeamWindow& window_;
  const std::int16_t alpha_;
  const Box box_, around_;
  Labels& labels_;
  GridCut cut_;
  std::vector<Cell> cells_;
};

}  // namespace

Labels cheapest_views(const SeamWindow& window) {
  Labels labels(window.width(), window.height(), 1, kNoView);
  for (int y = 0; y < labels.height; ++y) {
    for (int x = 0; x < labels.width; ++x) {
      int least = SeamWindow::kForbidden;
      for (const std::int16_t view : window.block(x / kBlock, y / kBlock).views)
        if (const int price = window.choice(x, y, view)->price; price < least) least = price, labels.at(x, y) = view;
    }
  }
  return labels;
}

void cut_seams(const SeamWindow& window, int first_x, int first_y, int last_x, int last_y, Labels& labels) {
  std::vector<std::int16_t> views;
  for (int j = 0; j < window.blocks_down(); ++j)
    for (int i = 0; i < window.blocks_across(); ++i)
      views.insert(views.end(), window.block(i, j).views.begin(), window.block(i, j).views.end());
  std::sort(views.begin(), views.end());
  views.erase(std::unique(views.begin(), views.end()), views.end());
  const Box free{first_x, first_y, last_x, last_y};
  // When a block last changed, and when a view last expanded: a move among labels that it has already met changes
  // nothing.
  int time = 0;
  std::vector<int> changed_at(std::size_t(window.blocks_across() * window.blocks_down())),
      expanded_at(views.size(), -1);
  for (int round = 0; round < kMostRounds; ++round) {
    bool changed = false;
    for (std::size_t k = 0; k < views.size(); ++k) {
      const Box box = box_of(window, views[k], free);
      if (box.left >= box.right || box.top >= box.bottom) continue;
      if (!changed_since(window, box, changed_at, expanded_at[k])) continue;
      expanded_at[k] = ++time;
      changed |= Expansion(window, views[k], box, labels).move(changed_at, time);
    }
    if (!changed) return;
  }
}

}  // namespace collinea
