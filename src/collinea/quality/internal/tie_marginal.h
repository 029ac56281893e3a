// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/quality/internal/error_mixture.h"

namespace collinea {

/// The distribution function of one coordinate of errors that have a given distribution of their length, alike in all
/// directions: of gross errors and of Student's, cut off where that is. To 0.001.
class TieMarginal {
 public:
  explicit TieMarginal(const ErrorDistribution& errors);
  [[nodiscard]] double operator()(double coordinate) const;

 private:
  double step_ = 1;  // of asinh(|coordinate| / scale)
  double scale_ = 1;
  std::vector<double> within_;  // probability of a smaller absolute value, at each step
};

}  // namespace collinea
