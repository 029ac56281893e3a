// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/mark_drawings.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// Weights of four neighbours by Catmull and Rom's cubic at t in [0, 1), and their derivatives.
void cubic(double t, std::array<double, 4>& weight, std::array<double, 4>& slope) {
  const double t2 = t * t, t3 = t2 * t;
  weight = {(-t3 + 2 * t2 - t) / 2, (3 * t3 - 5 * t2 + 2) / 2, (-3 * t3 + 4 * t2 + t) / 2, (t3 - t2) / 2};
  slope = {(-3 * t2 + 4 * t - 1) / 2, (9 * t2 - 10 * t) / 2, (-9 * t2 + 8 * t + 1) / 2, (3 * t2 - 2 * t) / 2};
}

}  // namespace

Mixture mixture_at(const Drawings& drawings, double blur_px2) {
  Mixture out;
  if (drawings.count < 3) return out;
  for (std::size_t k = 0; k < 3; ++k) {
    const double own = drawings.blur_px2(k), a = drawings.blur_px2((k + 1) % 3), b = drawings.blur_px2((k + 2) % 3);
    out.share[k] = (blur_px2 - a) * (blur_px2 - b) / ((own - a) * (own - b));
    out.by_blur[k] = (2 * blur_px2 - a - b) / ((own - a) * (own - b));
  }
  return out;
}

std::optional<DrawnSample> sample(const Drawings& drawings, const Mixture& mixture, const Vector2d& at) {
  const FloatImage& first = drawings.at[0]->values;
  const double x = at.x() - 0.5, y = at.y() - 0.5;
  if (!(x >= 1 && y >= 1 && x < first.width - 2 && y < first.height - 2)) return std::nullopt;
  const int x0 = int(x), y0 = int(y);
  std::array<double, 4> wx, wy, sx, sy;
  cubic(x - x0, wx, sx);
  cubic(y - y0, wy, sy);
  DrawnSample out;
  for (std::size_t k = 0; k < drawings.count; ++k)
    for (std::size_t j = 0; j < 4; ++j) {
      const float* row = drawings.at[k]->values.row(y0 - 1 + int(j)) + x0 - 1;
      double value = 0, slope = 0;
      for (std::size_t i = 0; i < 4; ++i) {
        value += wx[i] * double(row[i]);
        slope += sx[i] * double(row[i]);
      }
      out.value += mixture.share[k] * wy[j] * value;
      out.gradient += mixture.share[k] * Vector2d(wy[j] * slope, sy[j] * value);
      out.by_blur += mixture.by_blur[k] * wy[j] * value;
    }
  return out;
}

}  // namespace collinea
