// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/seams.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace collinea {
namespace {

constexpr int kBlock = OrthoPatch::kBlock;
constexpr std::size_t kBest = 8;    // views worth a look at a corner of a block
constexpr int kMajorityRadius = 5;  // [cells]
constexpr int kMajorityRounds = 2;

void label_whole_block(const OrthoPatch& patch, int block_x, int block_y, std::int16_t view, Labels& labels) {
  for (int y = block_y * kBlock; y < (block_y + 1) * kBlock; ++y)
    for (int x = block_x * kBlock; x < (block_x + 1) * kBlock; ++x)
      if (!std::isnan(patch.heights_m.at(x, y))) labels.at(x, y) = view;
}

// The cheapest view that sees the cell; where none does, the cheapest that just about does; else one of the cheapest
// that only small things keep from it.
std::int16_t cheapest_that_sees(std::span<const std::int16_t> candidates, std::span<float> costs, int x, int y,
                                Visibility& visibility) {
  std::array<std::int16_t, 4 * kBest> tried;
  for (std::size_t tries = 0; tries < candidates.size(); ++tries) {
    const std::size_t cheapest = std::size_t(std::min_element(costs.begin(), costs.end()) - costs.begin());
    tried[tries] = candidates[cheapest];
    if (visibility.sees(tried[tries], x, y)) return tried[tries];
    costs[cheapest] = 1e9f;
  }
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (visibility.sees_barely(tried[i], x, y)) return tried[i];
  for (std::size_t i = 0; i < std::min(kBest, candidates.size()); ++i)
    if (visibility.sees_past_small_things(tried[i], x, y)) return tried[i];
  return kNoView;
}

// The view that all cells of a block are to be taken from; kNoView where they differ.
std::int16_t wanted_throughout(const OrthoPatch& patch, const Labels& wanted, int block_x, int block_y) {
  std::int16_t throughout = kNoView;
  for (int y = block_y * kBlock; y < (block_y + 1) * kBlock; ++y) {
    for (int x = block_x * kBlock; x < (block_x + 1) * kBlock; ++x) {
      if (std::isnan(patch.heights_m.at(x, y))) continue;
      if (wanted.at(x, y) == kNoView || (throughout != kNoView && wanted.at(x, y) != throughout)) return kNoView;
      throughout = wanted.at(x, y);
    }
  }
  return throughout;
}

std::int16_t wanted_that_sees(const WantedViews& wanted, int x, int y, Visibility& visibility) {
  if (wanted.first.empty()) return kNoView;
  for (const std::int16_t view : {wanted.first.at(x, y), wanted.next.at(x, y)})
    if (view != kNoView && (visibility.sees(view, x, y) || visibility.sees_past_small_things(view, x, y))) return view;
  return kNoView;
}

void label_block(const OrthoPatch& patch, const CostLattice& lattice, const WantedViews& wanted, int block_x,
                 int block_y, Visibility& visibility, Labels& labels) {
  const std::vector<std::int16_t> candidates = candidates_of(lattice, block_x, block_y);
  if (candidates.empty()) return;  // no heights around
  const std::int16_t throughout = wanted.first.empty() ? best_throughout(lattice, candidates, block_x, block_y)
                                                       : wanted_throughout(patch, wanted.first, block_x, block_y);
  if (throughout != kNoView && visibility.sees_block(throughout, block_x, block_y))
    return label_whole_block(patch, block_x, block_y, throughout, labels);
  std::array<float, 4 * kBest> costs;
  for (int j = 0; j < kBlock; ++j) {
    for (int i = 0; i < kBlock; ++i) {
      const int x = block_x * kBlock + i, y = block_y * kBlock + j;
      if (std::isnan(patch.heights_m.at(x, y))) continue;
      labels.at(x, y) = wanted_that_sees(wanted, x, y, visibility);
      if (labels.at(x, y) != kNoView) continue;
      costs_in_block(lattice, candidates, block_x, block_y, i, j, costs.data());
      labels.at(x, y) = cheapest_that_sees(candidates, std::span(costs).first(candidates.size()), x, y, visibility);
    }
  }
}

// True where the labels around a cell are not all the same.
Raster<std::uint8_t> near_seams(const Labels& labels) {
  Raster<std::uint8_t> near(labels.width, labels.height);
  constexpr int r = kMajorityRadius;
  for (int y = 0; y < labels.height; ++y) {
    for (int x = 0; x < labels.width; ++x) {
      const bool seam = (x + 1 < labels.width && labels.at(x, y) != labels.at(x + 1, y)) ||
                        (y + 1 < labels.height && labels.at(x, y) != labels.at(x, y + 1));
      if (!seam) continue;
      for (int v = std::max(0, y - r); v <= std::min(labels.height - 1, y + r + 1); ++v)
        std::fill(near.row(v) + std::max(0, x - r), near.row(v) + std::min(labels.width, x + r + 2), std::uint8_t{1});
    }
  }
  return near;
}

std::int16_t majority(const Labels& labels, int x, int y, std::vector<int>& votes, Visibility& visibility) {
  constexpr int r = kMajorityRadius;
  std::fill(votes.begin(), votes.end(), 0);
  for (int v = std::max(0, y - r); v <= std::min(labels.height - 1, y + r); ++v)
    for (int u = std::max(0, x - r); u <= std::min(labels.width - 1, x + r); ++u)
      if (const auto label = labels.at(u, v); label != kNoView) ++votes[std::size_t(label)];
  const std::int16_t own = labels.at(x, y);
  std::int16_t best = own;
  for (std::size_t view = 0; view < votes.size(); ++view)
    if (votes[view] > votes[std::size_t(best)] && visibility.sees(int(view), x, y)) best = std::int16_t(view);
  return best;
}

bool is_wanted(const WantedViews& wanted, int x, int y, std::int16_t view) {
  return !wanted.first.empty() && (view == wanted.first.at(x, y) || view == wanted.next.at(x, y));
}

// Cells that could be taken as wanted stay.
void straighten(const WantedViews& wanted, std::size_t views, Visibility& visibility, Labels& labels) {
  std::vector<int> votes(views);
  for (int round = 0; round < kMajorityRounds; ++round) {
    const Raster<std::uint8_t> near = near_seams(labels);
    Labels next = labels;
    for (int y = 0; y < labels.height; ++y)
      for (int x = 0; x < labels.width; ++x)
        if (near.at(x, y) && labels.at(x, y) != kNoView && !is_wanted(wanted, x, y, labels.at(x, y)))
          next.at(x, y) = majority(labels, x, y, votes, visibility);
    labels = std::move(next);
  }
}

// Mean over (2r + 1) cells along rows (or columns); the outside counts as the border cell.
void box_blur(FloatImage& image, int r, bool along_rows) {
  const int lines = along_rows ? image.height : image.width, length = along_rows ? image.width : image.height;
  const std::size_t stride = along_rows ? 1 : std::size_t(image.width);
  std::vector<float> line(static_cast<std::size_t>(length));
  for (int k = 0; k < lines; ++k) {
    float* first = along_rows ? image.row(k) : image.data.data() + k;
    for (int i = 0; i < length; ++i) line[std::size_t(i)] = first[std::size_t(i) * stride];
    const auto cell = [&](int i) { return line[std::size_t(std::clamp(i, 0, length - 1))]; };
    double sum = 0;
    for (int i = -r; i <= r; ++i) sum += double(cell(i));
    for (int i = 0; i < length; ++i) {
      first[std::size_t(i) * stride] = float(sum / (2 * r + 1));
      sum += double(cell(i + r + 1)) - double(cell(i - r));
    }
  }
}

struct Box {
  int left, top, right, bottom;
};

Box box_of(const Labels& labels, std::int16_t view, int margin) {
  Box box{labels.width, labels.height, -1, -1};
  for (int y = 0; y < labels.height; ++y) {
    const auto* row = labels.row(y);
    for (int x = 0; x < labels.width; ++x) {
      if (row[x] != view) continue;
      box.left = std::min(box.left, x), box.right = std::max(box.right, x);
      box.top = std::min(box.top, y), box.bottom = y;
    }
  }
  if (box.right < 0) return box;
  return {std::max(0, box.left - margin), std::max(0, box.top - margin), std::min(labels.width - 1, box.right + margin),
          std::min(labels.height - 1, box.bottom + margin)};
}

}  // namespace

Labels choose_views(const OrthoPatch& patch, std::span<const View* const> views, const WantedViews& wanted,
                    Visibility& visibility) {
  Labels labels(patch.heights_m.width, patch.heights_m.height, 1, kNoView);
  if (views.empty()) return labels;
  const CostLattice lattice = costs_at_nodes(patch, views, patch.grid.cell_m, kBest);
  for (int y = 0; y < patch.blocks_down(); ++y)
    for (int x = 0; x < patch.blocks_across(); ++x) label_block(patch, lattice, wanted, x, y, visibility, labels);
  straighten(wanted, views.size(), visibility, labels);
  close_pinholes(patch.heights_m, views.size(), labels);
  return labels;
}

void close_pinholes(const FloatImage& heights_m, std::size_t views, Labels& labels) {
  constexpr int r = 2, kMostUnseen = 10;  // of 25 cells; a cell at the straight border of a hidden area has 15
  std::vector<int> votes(views);
  const Labels before = labels;
  for (int y = r; y < labels.height - r; ++y) {
    for (int x = r; x < labels.width - r; ++x) {
      if (before.at(x, y) != kNoView || std::isnan(heights_m.at(x, y))) continue;
      std::fill(votes.begin(), votes.end(), 0);
      int unseen = 0;
      for (int v = y - r; v <= y + r; ++v)
        for (int u = x - r; u <= x + r; ++u)
          before.at(u, v) == kNoView ? ++unseen : ++votes[std::size_t(before.at(u, v))];
      if (unseen <= kMostUnseen)
        labels.at(x, y) = std::int16_t(std::max_element(votes.begin(), votes.end()) - votes.begin());
    }
  }
}

ViewWeights weights_of(const Labels& labels, std::int16_t view, int feather_cells, Visibility& visibility) {
  const Box box = box_of(labels, view, feather_cells);
  ViewWeights result{box.left, box.top, {}};
  if (box.right < 0) return result;
  FloatImage area(box.right - box.left + 1, box.bottom - box.top + 1);
  Raster<std::uint8_t> seen(area.width, area.height, 1, 1);
  for (int y = 0; y < area.height; ++y)
    for (int x = 0; x < area.width; ++x) area.at(x, y) = labels.at(box.left + x, box.top + y) == view;
  const int half = std::max(1, feather_cells / 2);
  for (const bool along_rows : {true, false, true, false}) box_blur(area, half, along_rows);
  for (int y = 0; y < area.height; ++y)
    for (int x = 0; x < area.width; ++x)
      if (labels.at(box.left + x, box.top + y) != kNoView && area.at(x, y) > 1e-4f)
        seen.at(x, y) =
            labels.at(box.left + x, box.top + y) == view || visibility.sees(view, box.left + x, box.top + y);
  FloatImage far_from_hidden(area.width, area.height);
  std::copy(seen.data.begin(), seen.data.end(), far_from_hidden.data.begin());
  for (const bool along_rows : {true, false}) box_blur(far_from_hidden, half, along_rows);
  for (int y = 0; y < area.height; ++y) {
    for (int x = 0; x < area.width; ++x) {
      const bool own = labels.at(box.left + x, box.top + y) == view;
      const float weight = area.at(x, y) * std::max(0.0f, 2 * far_from_hidden.at(x, y) - 1);
      area.at(x, y) = own ? std::max(weight, 1e-3f) : (seen.at(x, y) > 0 && weight > 1e-3f ? weight : 0);
    }
  }
  result.weight = std::move(area);
  return result;
}

}  // namespace collinea
