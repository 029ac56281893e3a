// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/raster/raster.h"

namespace collinea {

/// Columns and rows where the middle of a window may lie, ends included.
struct SearchBand {
  int first_column, last_column, first_row, last_row;
};

struct BestCorrelation {
  Eigen::Vector2i pixel;        ///< middle of the window
  Eigen::Vector2d position_px;  ///< the top of the parabolas through the neighbours along column and row
  double ncc = 0;
  double sigma_px = 0;  ///< of the column: residual of the grey values over the gradients of the template
};

/// The window of `other` most like that of 2 half + 1 pixels round `middle`, by the correlation coefficient. Nothing
/// when the template leaves its image, holds pixels of 0 (nothing there) or is constant, when no window lies in the
/// other image, or when the best one lies at an end of the columns: then the best may lie beyond.
[[nodiscard]] std::optional<BestCorrelation> best_correlation(const GreyImage& image, const Eigen::Vector2i& middle,
                                                              int half, const GreyImage& other, const SearchBand& band);

}  // namespace collinea
