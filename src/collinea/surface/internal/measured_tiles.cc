// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/measured_tiles.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>

namespace collinea {
namespace {

constexpr int kCells = MeasuredTiles::kCells;
constexpr std::size_t kCellsOfTile = std::size_t(kCells) * kCells;

// The part of a square that lies in a window.
struct Overlap {
  int from_x, from_y, to_x, to_y, width, height;
};

Overlap overlap(const MeasuredTiles::Square& square, const CellWindow& window) {
  const std::int64_t column = square.first * kCells, row = square.second * kCells;
  const std::int64_t left = std::max(column, window.column), top = std::max(row, window.row);
  const std::int64_t right = std::min(column + kCells, window.column + window.width);
  const std::int64_t bottom = std::min(row + kCells, window.row + window.height);
  return {int(left - column),    int(top - row),    int(left - window.column),
          int(top - window.row), int(right - left), int(bottom - top)};
}

template <class Visit>
void each_raster(SurfaceTile& tile, Visit&& visit) {
  visit(tile.height_m);
  visit(tile.sigma_m);
  visit(tile.state);
  visit(tile.count);
}

template <class T>
void write(std::ofstream& file, const Raster<T>& raster) {
  file.write(reinterpret_cast<const char*>(raster.data.data()), std::streamsize(raster.data.size() * sizeof(T)));
}

void copy_part(const SurfaceTile& from, const Overlap& part, SurfaceTile& to) {
  const auto copy = [&](const auto& source, auto& target) {
    for (int y = 0; y < part.height; ++y)
      std::copy_n(source.row(part.from_y + y) + part.from_x, part.width, target.row(part.to_y + y) + part.to_x);
  };
  copy(from.height_m, to.height_m);
  copy(from.sigma_m, to.sigma_m);
  copy(from.state, to.state);
  copy(from.count, to.count);
}

bool read_part(const std::filesystem::path& path, const Overlap& part, SurfaceTile& to) {
  std::ifstream file(path, std::ios::binary);
  std::size_t begin = 0;  // of the raster in the file
  each_raster(to, [&](auto& raster) {
    const std::size_t size = sizeof(raster.data[0]);
    for (int y = 0; y < part.height; ++y) {
      const std::size_t cell = std::size_t(part.from_y + y) * kCells + std::size_t(part.from_x);
      file.seekg(std::streamoff(begin + cell * size));
      file.read(reinterpret_cast<char*>(raster.row(part.to_y + y) + part.to_x),
                std::streamsize(std::size_t(part.width) * size));
    }
    begin += kCellsOfTile * size;
  });
  return bool(file);
}

}  // namespace

MeasuredTiles::MeasuredTiles(std::filesystem::path scratch, std::size_t memory_bytes)
    : scratch_(std::move(scratch)), memory_bytes_(memory_bytes) {}

MeasuredTiles::~MeasuredTiles() {
  std::error_code ignored;
  for (const auto& [square, tile] : tiles_)
    if (tile.state.empty()) std::filesystem::remove(file_of(square), ignored);
}

std::filesystem::path MeasuredTiles::file_of(const Square& square) const {
  return scratch_ / ("measured_" + std::to_string(square.first) + "_" + std::to_string(square.second) + ".bin");
}

Result<> MeasuredTiles::add(const Square& square, SurfaceTile tile) {
  constexpr std::size_t kBytes = kCellsOfTile * (2 * sizeof(float) + sizeof(std::uint8_t) + sizeof(std::uint16_t));
  if (kept_ + kBytes <= memory_bytes_) {
    kept_ += kBytes;
    tiles_.emplace(square, std::move(tile));
    return {};
  }
  COLLINEA_TRY(scratch_.make());
  tiles_.emplace(square, SurfaceTile());
  std::ofstream file(file_of(square), std::ios::binary);
  each_raster(tile, [&](const auto& raster) { write(file, raster); });
  if (!file.flush()) return cannot_write(file_of(square));
  return {};
}

Result<SurfaceTile> MeasuredTiles::window(const CellWindow& window) const {
  SurfaceTile result(window.width, window.height);
  const std::int64_t last_column = floor_div(window.column + window.width - 1, kCells);
  const std::int64_t last_row = floor_div(window.row + window.height - 1, kCells);
  for (std::int64_t row = floor_div(window.row, kCells); row <= last_row; ++row) {
    for (std::int64_t column = floor_div(window.column, kCells); column <= last_column; ++column) {
      const auto found = tiles_.find({column, row});
      if (found == tiles_.end()) continue;
      const Overlap part = overlap(found->first, window);
      if (!found->second.state.empty())
        copy_part(found->second, part, result);
      else if (!read_part(file_of(found->first), part, result))
        return fail(Errc::kBadFormat, "cannot read back " + file_of(found->first).string());
    }
  }
  return result;
}

}  // namespace collinea
