// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "collinea/base/words.h"

namespace collinea {

/// What an observation costs as a function of s, the squared length of its residual in units of its sigma, and the
/// weight d(cost)/ds by which least squares imitates it.
///     none:   s
///     huber:  s up to k^2, beyond 2 k sqrt(s) - k^2   (Huber 1964)
///     cauchy: k^2 log(1 + s / k^2)
struct Loss {
  enum Kind { kNone, kHuber, kCauchy };
  Kind kind = kNone;
  double scale = 1;  ///< k [sigmas]
  /// Bound from below of curvature(). 1: plain reweighting, safe far from the solution; lower: close to Newton's
  /// method.
  double least_curvature = 1;
  /// Multiplies the weights, where they stand for what the group knows: RobustSquares::information().
  double information = 1;

  [[nodiscard]] double cost(double s) const {
    const double k2 = scale * scale;
    if (kind == kNone || (kind == kHuber && s <= k2)) return s;
    return kind == kHuber ? 2 * scale * std::sqrt(s) - k2 : k2 * std::log1p(s / k2);
  }
  [[nodiscard]] double weight(double s) const {
    const double k2 = scale * scale;
    if (kind == kNone || (kind == kHuber && s <= k2)) return information;
    return information * (kind == kHuber ? scale / std::sqrt(s) : 1 / (1 + s / k2));
  }
  /// How weight(s) * residual grows with the residual along it; across it, it grows with weight(s).
  [[nodiscard]] double slope(double s) const {
    const double k2 = scale * scale;
    if (kind == kNone || (kind == kHuber && s <= k2)) return information;
    return kind == kHuber ? 0 : weight(s) * (k2 - s) / (k2 + s);
  }
  /// The second derivative of the cost along the residual, relative to weight(s): 1 + 2 s weight'(s) / weight(s)
  /// (Triggs et al. 2000), bounded from below; 1 for gross outliers, whose flat cost would send their points far away.
  [[nodiscard]] double curvature(double s) const {
    const double k2 = scale * scale;
    if (kind == kNone || (kind == kHuber && s <= k2) || s > 16 * k2) return 1;
    return std::max(least_curvature, kind == kHuber ? 0 : (k2 - s) / (k2 + s));
  }
};

/// Sums up the costs of observations; of Cauchy's loss the logarithms are taken together, as one of a product.
class CostSum {
 public:
  explicit CostSum(const Loss& loss) : loss_(loss) {}
  /// s as in Loss::cost.
  void add(double s) {
    if (loss_.kind != Loss::kCauchy) {
      sum_ += loss_.cost(s);
      return;
    }
    product_ *= 1 + s / (loss_.scale * loss_.scale);
    if (product_ > 1e200) [[unlikely]] {
      sum_ = value();
      product_ = 1;
    }
  }
  [[nodiscard]] double value() const {
    return product_ == 1 ? sum_ : sum_ + loss_.scale * loss_.scale * std::log(product_);
  }

 private:
  const Loss& loss_;
  double sum_ = 0, product_ = 1;
};

inline constexpr Word<Loss::Kind> kLossWords[] = {
    {Loss::kNone, "none"}, {Loss::kHuber, "huber"}, {Loss::kCauchy, "cauchy"}};
[[nodiscard]] constexpr std::span<const Word<Loss::Kind>> words(Loss::Kind) { return kLossWords; }

}  // namespace collinea
