// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "collinea/dense/internal/labels.h"

namespace collinea::dense {

/// A rectangle of whole cells.
struct CellRange {
  int column0 = 0, row0 = 0, column1 = 0, row1 = 0;  ///< ends excluded
};

/// What a change of depth between neighbouring pixels costs, on the scale of cost().
struct Smoothness {
  GreyImage small;                         ///< by one label, for each pixel; more where there is little texture
  std::array<std::uint16_t, 256> large{};  ///< by more, for each difference of grey values
};
[[nodiscard]] Smoothness smoothness_for(const GreyImage& image);
/// Smoothness::small for texture_around().
[[nodiscard]] std::array<std::uint8_t, 256> small_for_textures();

/// The matching costs of a rectangle of cells; cell offsets as in `offsets`, by rows of the rectangle.
struct Volume {
  CellRange range;
  std::vector<std::size_t> offsets;
  std::vector<std::uint8_t> costs;

  [[nodiscard]] std::size_t offset(int column, int row) const {
    return offsets[std::size_t(row - range.row0) * std::size_t(range.column1 - range.column0) +
                   std::size_t(column - range.column0)];
  }
};

/// What matching these cells takes: their volume and the sums of it.
[[nodiscard]] std::size_t bytes_to_match(const Labels& labels, const CellRange& range);

/// Room for the costs of the cells in `range`, all 255 (guards stay so).
[[nodiscard]] Volume volume_for(const Labels& labels, const CellRange& range);

/// Semi-global aggregation (Hirschmueller 2008) along eight directions: the sums of path costs, laid out as the volume.
/// A path that keeps its label follows the base of the labels, so a sloping base is not penalised; between cells labels
/// are carried over by inverse depth. `stopped` is asked between rows; when it says yes the result is meaningless.
[[nodiscard]] std::vector<std::uint16_t> aggregate(const Labels& labels, const Volume& volume, const GreyImage& image,
                                                   const Smoothness& smoothness, const std::function<bool()>& stopped);

/// The label with the smallest sum (the first of them) and, between labels, the minimum of the parabola.
[[nodiscard]] float winner(const std::uint16_t* sums_of_pixel, int labels);

}  // namespace collinea::dense
