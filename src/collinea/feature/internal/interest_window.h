// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "collinea/feature/interest_options.h"

// What a response of an operator is made of.
namespace collinea {

inline constexpr double kDogRatio = 1.6;  ///< of the two blurs: nearest to the Laplacian (Marr and Hildreth 1980)

[[nodiscard]] inline bool is_blob(InterestOperator method) {
  return method == InterestOperator::kLog || method == InterestOperator::kDog || method == InterestOperator::kSift;
}

[[nodiscard]] inline int window_radius(const InterestOptions& o) {
  if (o.window_radius_px) return *o.window_radius_px;
  if (o.method == InterestOperator::kMoravec) return 1;
  const double widest = o.method == InterestOperator::kDog || o.method == InterestOperator::kSift ? kDogRatio : 1;
  return std::max(1, static_cast<int>(std::ceil((is_blob(o.method) ? 4 : 3) * widest * o.sigma_px)));
}

}  // namespace collinea
