// SPDX-License-Identifier: Apache-2.0
#include "collinea/ortho/kept_orthophoto.h"

#include <algorithm>
#include <limits>
#include <set>

namespace collinea {

OrthoTally tally_of(const OrthoTile& tile) {
  OrthoTally tally;
  std::set<std::uint16_t> used;
  std::uint16_t last = 0;
  for (const std::uint16_t source : tile.source.data) {
    (source ? tally.painted_cells : tally.empty_cells)++;
    if (source && source != last) used.insert(last = source);
  }
  tally.used.assign(used.begin(), used.end());
  tally.seams = tile.seams;
  tally.not_followed = tile.not_followed;
  return tally;
}

SourceRuns runs_of(const Raster<std::uint16_t>& raster) {
  constexpr std::uint32_t kLongest = std::numeric_limits<std::uint32_t>::max();
  SourceRuns runs{raster.width, raster.height, {}, {}};
  for (const std::uint16_t source : raster.data) {
    if (runs.sources.empty() || runs.sources.back() != source || runs.lengths.back() == kLongest) {
      runs.sources.push_back(source);
      runs.lengths.push_back(0);
    }
    ++runs.lengths.back();
  }
  return runs;
}

std::optional<Raster<std::uint16_t>> raster_of(const SourceRuns& runs) {
  std::uint64_t cells = 0;
  for (const std::uint32_t length : runs.lengths) cells += length;
  const bool is_whole = runs.width >= 0 && runs.height >= 0 && runs.lengths.size() == runs.sources.size() &&
                        cells == std::uint64_t(runs.width) * std::uint64_t(runs.height);
  if (!is_whole) return std::nullopt;
  Raster<std::uint16_t> raster(runs.width, runs.height);
  auto cell = raster.data.begin();
  for (std::size_t i = 0; i < runs.lengths.size(); ++i) cell = std::fill_n(cell, runs.lengths[i], runs.sources[i]);
  return raster;
}

namespace {

// Those of a list that another one has as well, or has not.
std::vector<SeamPolygon> of_which(std::span<const SeamPolygon> all, std::span<const SeamPolygon> other, bool has) {
  std::vector<SeamPolygon> chosen;
  for (const SeamPolygon& one : all)
    if ((std::ranges::find(other, one) != other.end()) == has) chosen.push_back(one);
  return chosen;
}

}  // namespace

std::vector<SeamPolygon> changed_patches(std::span<const SeamPolygon> before, std::span<const SeamPolygon> after) {
  const bool is_order_kept = of_which(before, after, true) == of_which(after, before, true);
  if (!is_order_kept) {
    std::vector<SeamPolygon> all(before.begin(), before.end());
    all.insert(all.end(), after.begin(), after.end());
    return all;
  }
  std::vector<SeamPolygon> changed = of_which(before, after, false);
  for (SeamPolygon& one : of_which(after, before, false)) changed.push_back(std::move(one));
  return changed;
}

bool reaches(const SeamPolygon& patch, const MapGrid& grid, const CellArea& area) {
  constexpr double kReach = kOrthoTileReach + 1;  // sides of seams are those of a cell and its neighbour
  double first_column = grid.width, last_column = 0, first_row = grid.height, last_row = 0;
  for (const MapRing& ring : patch.rings)
    for (const Eigen::Vector2d& corner : ring) {
      first_column = std::min(first_column, grid.column_of(corner.x()));
      last_column = std::max(last_column, grid.column_of(corner.x()));
      first_row = std::min(first_row, grid.row_of(corner.y()));
      last_row = std::max(last_row, grid.row_of(corner.y()));
    }
  return first_column - kReach < area.column + area.width && last_column + kReach > area.column &&
         first_row - kReach < area.row + area.height && last_row + kReach > area.row;
}

}  // namespace collinea
