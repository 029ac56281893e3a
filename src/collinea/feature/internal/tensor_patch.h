// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/feature/internal/interest_kernels.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Responses of an operator on the structure tensor round a pixel, from the pixels alone that they depend on: the same
/// bits as those of a map of the image.
class TensorPatch {
 public:
  /// `taps` of the window, from the middle outwards.
  TensorPatch(std::vector<float> taps, GradientMask mask, CornerMeasure measure, float parameter);

  /// Columns and rows round the pixel that must lie in the image.
  [[nodiscard]] int reach() const { return radius_ + 2; }
  void take(const GreyImage& image, int column, int row);
  /// A pixel of the patch, from the middle.
  void replace(int dx, int dy, float grey) { grey_[index(dx, dy)] = grey; }
  /// The largest response at the 3 x 3 pixels in the middle; at least 0.
  [[nodiscard]] float strongest();

 private:
  [[nodiscard]] std::size_t index(int dx, int dy) const {
    return std::size_t(dy + reach()) * stride_ + std::size_t(dx + reach()) + 1;
  }

  std::vector<float> taps_;
  GradientMask mask_;
  CornerMeasure measure_;
  float parameter_;
  int radius_;
  std::size_t stride_;
  std::vector<float> grey_, products_, along_, across_;
};

}  // namespace collinea
