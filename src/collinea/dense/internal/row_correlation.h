// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "collinea/raster/raster.h"

namespace collinea {

/// Columns and rows where the middle of a window may lie, ends included.
struct SearchBand {
  int first_column, last_column, first_row, last_row;
};

/// Where the pixel (u, v) of a pattern, counted from its middle, lies in the image: (stretch u + shear v, v).
struct PatternShape {
  double stretch = 1, shear = 0;
};

/// The grey values of 2 half + 1 pixels round a middle as whole numbers, so that correlations have the same bits
/// everywhere.
struct WindowPattern {
  /// Nothing when the window and a pixel round it leave the image, when it holds pixels of 0 (nothing there), or is
  /// constant or without slope along rows.
  static std::optional<WindowPattern> of(const GreyImage& image, const Eigen::Vector2i& middle, int half);
  /// The same of a window that is sheared and stretched along rows, by cubic convolution, in parts of a grey value.
  static std::optional<WindowPattern> of(const GreyImage& image, const Eigen::Vector2i& middle, int half,
                                         const PatternShape& shape);

  std::vector<std::int16_t> grey;  ///< rows of `width`
  int half = 0, width = 0;
  std::int64_t sum = 0, squares = 0, gradients = 0;  ///< gradients: squares of differences of pixels two apart
  std::int64_t count = 0;

  [[nodiscard]] double spread() const { return double(count * squares - sum * sum); }
  void add(int u, int v, std::int16_t value, std::int32_t slope);
};

struct BestCorrelation {
  Eigen::Vector2i pixel;        ///< middle of the window
  Eigen::Vector2d position_px;  ///< the top of the parabolas through the neighbours along column and row
  double ncc = 0;
  double sigma_px = 0;  ///< of the column: residual of the grey values over the gradients of the pattern
};

/// The windows of an image whose middles lie in a band, to be compared with any number of patterns.
class SearchedBand {
 public:
  /// Of what lies in the image; it may be empty. The image must outlive it.
  SearchedBand(const GreyImage& image, int half, const SearchBand& band);

  /// The window most like a pattern of the same size by the correlation coefficient, on the row where that reaches
  /// highest between columns. Nothing when the band is empty, or
  /// when the best one lies at an end of the columns: then the best may lie beyond.
  [[nodiscard]] std::optional<BestCorrelation> best(const WindowPattern& pattern) const;

 private:
  void sum_windows(int side);
  [[nodiscard]] std::vector<double> correlations(const WindowPattern& pattern) const;
  [[nodiscard]] bool is_empty() const { return columns_ <= 0 || rows_ <= 0; }

  const GreyImage* image_;
  int half_, first_column_, first_row_, columns_, rows_, stride_ = 0;
  std::vector<std::uint8_t> pixels_;  // rows of stride_
  std::vector<std::int64_t> sums_;    // of each window
  std::vector<double> by_spread_;     // 1 / sqrt(count squares - sum^2); 0 where it is constant
};

/// The window of `other` in a band most like that of 2 half + 1 pixels round `middle` of `image`. Nothing as
/// WindowPattern::of() and SearchedBand::best().
[[nodiscard]] std::optional<BestCorrelation> best_correlation(const GreyImage& image, const Eigen::Vector2i& middle,
                                                              int half, const GreyImage& other, const SearchBand& band);

}  // namespace collinea
