// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace collinea {

/// Corresponding image coordinates, four arrays.
struct PairRows {
  const double *x1, *y1, *x2, *y2;
};

/// Squared lengths of a pixel of both images, of all pairs (one value each) or of each pair.
struct SquaredPixels {
  const double *first, *second;
  bool varies;
};

/// out[i] = the squared Sampson distance of pair i to the matrix (row by row): c^2 / (second (a^2 + b^2) + first (u^2 +
/// v^2)), c = q' M p, (a, b, .) = M p, (u, v, .) = M' q. Products are rounded before they are added: the same bits with
/// any number of lanes, and those of a plain loop.
void sampson_distances(const std::array<double, 9>& matrix, const PairRows& pairs, int count,
                       const SquaredPixels& pixels, double* out);

}  // namespace collinea
