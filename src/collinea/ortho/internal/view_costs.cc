// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/internal/view_costs.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr int kBlock = OrthoPatch::kBlock;

// The mean height of the blocks around each corner; NaN where there is none. Only what lies around counts, so that
// neighbouring patches agree.
FloatImage node_heights(const OrthoPatch& patch) {
  FloatImage sums(patch.blocks_across() + 1, patch.blocks_down() + 1), counts = sums;
  for (int by = 0; by < patch.blocks_down(); ++by) {
    for (int bx = 0; bx < patch.blocks_across(); ++bx) {
      double sum = 0;
      int count = 0;
      for (int y = by * kBlock; y < (by + 1) * kBlock; ++y)
        for (int x = bx * kBlock; x < (bx + 1) * kBlock; ++x)
          if (const float z = patch.heights_m.at(x, y); !std::isnan(z)) sum += double(z), ++count;
      if (count == 0) continue;
      for (int corner = 0; corner < 4; ++corner) {
        sums.at(bx + (corner & 1), by + (corner >> 1)) += float(sum / count);
        counts.at(bx + (corner & 1), by + (corner >> 1)) += 1;
      }
    }
  }
  for (std::size_t i = 0; i < sums.data.size(); ++i) sums.data[i] /= counts.data[i];  // 0 / 0 is the NaN that is wanted
  return sums;
}

}  // namespace

CostLattice costs_at_nodes(const OrthoPatch& patch, std::span<const View* const> views, double cell_m,
                           std::size_t most) {
  const FloatImage heights_m = node_heights(patch);
  CostLattice lattice;
  lattice.columns = heights_m.width, lattice.rows = heights_m.height, lattice.views = views.size();
  const std::size_t nodes = heights_m.data.size();
  lattice.costs.assign(nodes * views.size(), 2 * kUseless);
  lattice.best.resize(nodes);
  std::vector<std::int16_t> order(views.size());
  for (int j = 0; j < lattice.rows; ++j) {
    for (int i = 0; i < lattice.columns; ++i) {
      const float z = heights_m.at(i, j);
      if (std::isnan(z)) continue;
      const std::size_t node = std::size_t(j) * std::size_t(lattice.columns) + std::size_t(i);
      float* costs = lattice.costs.data() + node * views.size();
      const Eigen::Vector3d position = patch.lattice.at(i * kBlock, j * kBlock, double(z));
      for (std::size_t v = 0; v < views.size(); ++v) {
        costs[v] = cost_of(*views[v], position, cell_m);
        order[v] = std::int16_t(v);
      }
      const auto kept = std::ptrdiff_t(std::min(most, views.size()));
      std::partial_sort(order.begin(), order.begin() + kept, order.end(), [&](std::int16_t a, std::int16_t b) {
        return costs[a] != costs[b] ? costs[a] < costs[b] : a < b;
      });
      lattice.best[node].assign(order.begin(), order.begin() + kept);
    }
  }
  return lattice;
}

std::vector<std::int16_t> candidates_of(const CostLattice& lattice, int block_x, int block_y) {
  std::vector<std::int16_t> candidates;
  for (int corner = 0; corner < 4; ++corner) {
    const auto& best = lattice.best[std::size_t(block_y + (corner >> 1)) * std::size_t(lattice.columns) +
                                    std::size_t(block_x + (corner & 1))];
    candidates.insert(candidates.end(), best.begin(), best.end());
  }
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  return candidates;
}

// The view that is the best at all four corners, and so everywhere between them; kNoView when there is none.
std::int16_t best_throughout(const CostLattice& lattice, std::span<const std::int16_t> candidates, int block_x,
                             int block_y) {
  std::int16_t best = kNoView;
  for (int corner = 0; corner < 4; ++corner) {
    const float* costs = lattice.at(block_x + (corner & 1), block_y + (corner >> 1));
    std::int16_t here = candidates.front();
    for (const std::int16_t v : candidates)
      if (costs[v] < costs[here]) here = v;
    if (corner > 0 && here != best) return kNoView;
    best = here;
  }
  return best;
}

void costs_in_block(const CostLattice& lattice, std::span<const std::int16_t> candidates, int block_x, int block_y,
                    int i, int j, float* costs) {
  const float *c00 = lattice.at(block_x, block_y), *c10 = lattice.at(block_x + 1, block_y);
  const float *c01 = lattice.at(block_x, block_y + 1), *c11 = lattice.at(block_x + 1, block_y + 1);
  const float a = (float(i) + 0.5f) / kBlock, b = (float(j) + 0.5f) / kBlock;
  for (std::size_t k = 0; k < candidates.size(); ++k) {
    const auto v = candidates[k];
    costs[k] = (1 - b) * ((1 - a) * c00[v] + a * c10[v]) + b * ((1 - a) * c01[v] + a * c11[v]);
  }
}

}  // namespace collinea
