// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "collinea/feature/edge_map.h"

namespace collinea {

/// Correlation of the errors of two points of one edge across it, for filters overlap: exp(-d^2 / (4 along^2)) times
/// the cosine of the angle of their normals; 0 beyond a right angle. `along_px` is that of EdgeMap, at least 0.001.
[[nodiscard]] inline double edge_correlation(const EdgePoint& a, const EdgePoint& b, double along_px) {
  const double along = std::max(along_px, 1e-3);
  return std::exp(-(a.at - b.at).squaredNorm() / (4 * along * along)) * std::max(0.0, a.normal.dot(b.normal));
}

}  // namespace collinea
