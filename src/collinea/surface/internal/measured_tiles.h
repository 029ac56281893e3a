// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <utility>

#include "collinea/base/result.h"
#include "collinea/surface/internal/gridding.h"
#include "collinea/surface/internal/scratch_folder.h"

namespace collinea {

/// A surface model in squares of kCells x kCells cells, held in memory up to a limit and beyond it in files of a
/// scratch folder, which are removed again at the end.
class MeasuredTiles {
 public:
  static constexpr int kCells = 512;
  using Square = std::pair<std::int64_t, std::int64_t>;  ///< column and row of a square, in squares

  MeasuredTiles(std::filesystem::path scratch, std::size_t memory_bytes);
  ~MeasuredTiles();
  MeasuredTiles(const MeasuredTiles&) = delete;
  MeasuredTiles& operator=(const MeasuredTiles&) = delete;

  /// Takes a square that was not there. Not from several threads at once.
  Result<> add(const Square& square, SurfaceTile tile);

  /// A window of the model; empty where there are no squares. May be called from several threads at once (not while
  /// squares are added).
  [[nodiscard]] Result<SurfaceTile> window(const CellWindow& window) const;

 private:
  [[nodiscard]] std::filesystem::path file_of(const Square& square) const;

  ScratchFolder scratch_;
  std::size_t memory_bytes_, kept_ = 0;
  std::map<Square, SurfaceTile> tiles_;  // without rasters: in a file
};

}  // namespace collinea
