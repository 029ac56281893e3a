// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/peak_paraboloid.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;

// The residual sum of squares (of sad: the sum of the absolute residuals) of which the extremum is sought. Of ncc and
// cosine that with the gain at the candidate `pixel`: the correlation itself would move towards windows of more
// contrast, where the same noise counts less.
double objective(const CorrelationSurface& surface, const Vector2i& pixel, const Vector2i& at) {
  const double value = surface.values.at(at.x(), at.y()), n = surface.pixels;
  if (is_larger_better(surface.method)) {
    const double here = surface.deviations.at(at.x(), at.y()), first = surface.deviations.at(pixel.x(), pixel.y());
    return here * here + first * first - 2 * value * here * first;
  }
  if (surface.method == Similarity::kD) return value * value;
  return surface.method == Similarity::kDn ? n * value * value : value;
}

}  // namespace

// The columns of 1, x, y, x^2, xy, y^2 at (x, y) = -1, 0, 1 are orthogonal but for 1 and the squares, so that the
// solution can be written down.
PeakParaboloid peak_paraboloid(const CorrelationSurface& surface, int column, int row) {
  double sum = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x) {
      const double z = objective(surface, {column, row}, {column + x, row + y});
      sum += z;
      sx += x * z;
      sy += y * z;
      sxx += x * x * z;
      sxy += x * y * z;
      syy += y * y * z;
    }
  const double xx = sxx / 2 - sum / 3, yy = syy / 2 - sum / 3, xy = sxy / 4;
  PeakParaboloid out{(5 * sum - 3 * (sxx + syy)) / 9, Vector2d(sx / 6, sy / 6), {}};
  out.hesse << 2 * xx, xy, xy, 2 * yy;
  return out;
}

}  // namespace collinea
