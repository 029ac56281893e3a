// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/spread.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace collinea {
namespace {

constexpr double kSpotsPerCell = 16;

// Cells of equal size, nearly square, about kSpotsPerCell wanted spots in each.
class Grid {
 public:
  Grid(int width, int height, int wanted) {
    const double cell_px = std::sqrt(double(width) * height * kSpotsPerCell / std::max(1, wanted));
    columns_ = std::max(1, static_cast<int>(std::lround(width / cell_px)));
    rows_ = std::max(1, static_cast<int>(std::lround(height / cell_px)));
    per_x_ = double(columns_) / width;
    per_y_ = double(rows_) / height;
  }
  [[nodiscard]] std::size_t size() const {
    return static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  }
  [[nodiscard]] std::size_t cell_of(const Spot& spot) const {
    const int column = std::clamp(static_cast<int>(spot.x * per_x_), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(spot.y * per_y_), 0, rows_ - 1);
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
  }

 private:
  int columns_ = 1, rows_ = 1;
  double per_x_ = 0, per_y_ = 0;
};

}  // namespace

std::vector<std::uint32_t> spread_order(std::span<const Spot> spots, int width, int height, int wanted,
                                        double even_share) {
  std::vector<std::uint32_t> order(spots.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::uint32_t i) { return spots[i].strength; });
  if (order.size() <= static_cast<std::size_t>(std::max(0, wanted))) return order;

  // Sorted by strength as they are, the rank of a spot in its cell says how many the cell has when it is taken.
  const Grid grid(width, height, wanted);
  std::vector<std::uint32_t> taken(grid.size()), rank(spots.size());
  for (const std::uint32_t i : order) rank[i] = taken[grid.cell_of(spots[i])]++;
  const auto strongest = static_cast<std::ptrdiff_t>(std::lround(wanted * (1 - even_share)));
  std::ranges::stable_sort(order.begin() + strongest, order.end(), {}, [&](std::uint32_t i) { return rank[i]; });
  return order;
}

}  // namespace collinea
