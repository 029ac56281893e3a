// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "collinea/feature/internal/scale_space.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A symmetric filter along rows and across them: taps from the middle outwards.
struct SeparableFilter {
  std::vector<float> along, across;
};

/// Taps of a Gaussian that sum to 1 (both sides counted).
[[nodiscard]] std::vector<float> gaussian_window(double sigma_px, int radius_px);
/// Taps of the second derivative of a Gaussian: they sum to 0, and turn x^2 into 2.
[[nodiscard]] std::vector<float> gaussian_curvature(double sigma_px, int radius_px);
[[nodiscard]] std::vector<float> box_window(int radius_px);  ///< ones

/// Several channels filtered at once, row by row: only the rows within the window are held. All taps are of the same
/// length. The border is repeated outwards.
class SeparableRows {
 public:
  /// Writes the rows of all channels, as they come; rows have kRowSlack floats beyond their end.
  using Source = std::function<void(int y, std::span<float* const> rows)>;
  /// Receives the filtered rows, upper first; it may write on them.
  using Sink = std::function<void(int y, std::span<float* const> rows)>;

  SeparableRows(int width, int height, std::vector<SeparableFilter> filters);
  void run(const Source& source, const Sink& sink);

 private:
  void fill(const Source& source, int y);

  std::vector<SeparableFilter> filters_;
  int radius_, width_, height_;
  std::vector<Plane> rings_;
  std::vector<std::vector<float>> padded_;
  std::vector<float*> source_rows_;
};

/// The columns [begin, begin + width) of an image as rows of floats; columns and rows beside the image repeat its
/// border. Three rows are kept, to be read in ascending order from `y - 1` to `y + 1`.
class FloatRows {
 public:
  FloatRows(const GreyImage& image, int begin, int width);
  /// Row y, readable from column -1 to width + slack. Valid until two more rows are asked for.
  [[nodiscard]] const float* row(int y);

 private:
  const GreyImage& image_;
  int begin_, width_;
  Plane ring_;
  std::vector<int> held_;
};

}  // namespace collinea
