// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "collinea/math/robust.h"

namespace collinea {

/// What a group of residuals under a robust loss says of its sigmas, and what its weights are worth. Without a loss:
/// the sum of squares, and 1.
class RobustSquares {
 public:
  explicit RobustSquares(const Loss& loss) : loss_(loss) { loss_.information = 1; }

  /// A residual of squared whitened length s, in 1 to 3 coordinates.
  void add(double s, int coordinates);

  /// The sum of squares that normal residuals with the same sum of w s would have: its mean is the variance of the
  /// residuals times their number whatever the loss.
  [[nodiscard]] double squares() const;
  /// The sum of w s.
  [[nodiscard]] double weighted() const { return weighted_; }
  /// By what the weights w are to be multiplied so that the inverse normal equations times the variance are the
  /// covariance of the robust estimate (Huber 1981, 7.6), when so many unknowns are determined by each coordinate.
  [[nodiscard]] double information(double unknowns_per_coordinate) const;

 private:
  [[nodiscard]] double variance() const;

  Loss loss_;
  std::array<double, 4> count_{};  // of residuals, by their coordinates
  double coordinates_ = 0, weighted_ = 0, twice_weighted_ = 0, weights_ = 0, slopes_ = 0, squared_slopes_ = 0;
};

}  // namespace collinea
