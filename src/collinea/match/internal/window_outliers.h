// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/match/internal/window_fit.h"

namespace collinea {

/// Which points of a window do not belong to the rest. A point is judged by its residual and by the mean of the 3 x 3
/// residuals round it, each against its median absolute value: what hides a part of a window covers neighbours, so that
/// their mean is far out where each of them alone might be noise.
class WindowOutliers {
 public:
  void begin(const WindowFit& fit);
  /// Weights that fall to 0 with the residual (Tukey's biweight), to find the way to the solution.
  const float* soft(const WindowFit& fit);
  /// Leaves out the points whose residual, or mean of residuals, noise would exceed once in twenty windows, with those
  /// round them. Whether these are others than before.
  bool reject(const WindowFit& fit);
  [[nodiscard]] const float* factors() const { return factors_.data(); }
  [[nodiscard]] double share_used() const { return share_used_; }

 private:
  void judge(const WindowFit& fit);

  std::vector<float> out_of_, factors_, means_, sorted_;
  double share_used_ = 1;
};

}  // namespace collinea
