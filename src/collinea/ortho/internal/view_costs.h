// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "collinea/ortho/internal/visibility.h"

namespace collinea {

/// The number that stands for no view.
constexpr std::int16_t kNoView = -1;

/// cost_of all views at the corners of the blocks of a patch, and the best few there.
struct CostLattice {
  int columns = 0, rows = 0;
  std::size_t views = 0;
  std::vector<float> costs;                     ///< [corner][view]
  std::vector<std::vector<std::int16_t>> best;  ///< per corner, the cheapest first

  [[nodiscard]] const float* at(int i, int j) const {
    return costs.data() + (std::size_t(j) * std::size_t(columns) + std::size_t(i)) * views;
  }
};
/// `most`: how many views are worth a look at a corner; `cell_m`: of the orthophoto that they are to serve.
[[nodiscard]] CostLattice costs_at_nodes(const OrthoPatch& patch, std::span<const View* const> views, double cell_m,
                                         std::size_t most);

/// The best views of the four corners of a block, ascending; empty where there are no heights around.
[[nodiscard]] std::vector<std::int16_t> candidates_of(const CostLattice& lattice, int block_x, int block_y);

/// The view that is the best at all four corners, and so everywhere between them; kNoView when there is none.
[[nodiscard]] std::int16_t best_throughout(const CostLattice& lattice, std::span<const std::int16_t> candidates,
                                           int block_x, int block_y);

/// The costs of the candidates of a block in its cell (i, j), bilinear between its corners.
void costs_in_block(const CostLattice& lattice, std::span<const std::int16_t> candidates, int block_x, int block_y,
                    int i, int j, float* costs);

}  // namespace collinea
