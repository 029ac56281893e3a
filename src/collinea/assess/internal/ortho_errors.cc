// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/ortho_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr int kHalf = 15;            // of the window [px]
constexpr int kSearch = 6;           // [px]
constexpr int kSpacing = 48;         // [px]
constexpr double kLeastTexture = 9;  // mean squared gradient in the weakest direction [grey^2 / px^2]
constexpr double kLeastAlike = 0.6;  // correlation
constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

FloatImage grey_of(const Raster<std::uint8_t>& image) {
  FloatImage grey(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t* p = image.row(y) + x * image.channels;
      const float value = image.channels >= 3 ? 0.299f * p[0] + 0.587f * p[1] + 0.114f * p[2] : float(p[0]);
      grey.at(x, y) = image.channels == 4 && p[3] == 0 ? kNothing : value;
    }
  }
  return grey;
}

// A window of an image, cells of `grid` from (column, row); what lies outside the image is nothing.
Result<FloatImage> grey_window(const ImageField& field, int column, int row, int width, int height) {
  FloatImage grey(width, height, 1, kNothing);
  const int left = std::max(0, column), top = std::max(0, row);
  const int right = std::min(field.grid.width, column + width), bottom = std::min(field.grid.height, row + height);
  if (right <= left || bottom <= top) return grey;
  COLLINEA_TRY(const auto image, field.read(left, top, right - left, bottom - top));
  const FloatImage part = grey_of(image);
  for (int y = 0; y < part.height; ++y) std::copy_n(part.row(y), part.width, grey.row(top - row + y) + left - column);
  return grey;
}

// The truth at the pixel centres of a strip of the product.
Result<FloatImage> resampled(const ImageField& truth, const MapGrid& product, int row, int height) {
  const auto x_of = [&](double column) { return truth.grid.column_of(product.east_of(column)); };
  const auto y_of = [&](double r) { return truth.grid.row_of(product.north_of(r)); };
  const int left = int(std::floor(x_of(0))) - 2, right = int(std::ceil(x_of(product.width))) + 2;
  const int top = int(std::floor(y_of(row))) - 2, bottom = int(std::ceil(y_of(row + height))) + 2;
  COLLINEA_TRY(const FloatImage grey, grey_window(truth, left, top, right - left, bottom - top));
  FloatImage result(product.width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < product.width; ++x)
      result.at(x, y) = bilinear(grey, x_of(x + 0.5) - left, y_of(row + y + 0.5) - top);
  return result;
}

bool complete(const FloatImage& grey, int x, int y, int half) {
  for (int v = y - half; v <= y + half; ++v)
    for (int u = x - half; u <= x + half; ++u)
      if (std::isnan(grey.at(u, v))) return false;
  return true;
}

bool textured(const FloatImage& grey, int x, int y) {
  double xx = 0, xy = 0, yy = 0;
  for (int v = y - kHalf; v <= y + kHalf; ++v) {
    for (int u = x - kHalf; u <= x + kHalf; ++u) {
      const double dx = double(grey.at(u + 1, v) - grey.at(u - 1, v)) / 2,
                   dy = double(grey.at(u, v + 1) - grey.at(u, v - 1)) / 2;
      xx += dx * dx, xy += dx * dy, yy += dy * dy;
    }
  }
  const double n = (2 * kHalf + 1) * (2 * kHalf + 1), mean = (xx + yy) / 2 / n;
  return mean - std::hypot((xx - yy) / 2, xy) / n > kLeastTexture;
}

double correlation(const FloatImage& a, int ax, int ay, const FloatImage& b, int bx, int by) {
  double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int v = -kHalf; v <= kHalf; ++v) {
    const float *pa = a.row(ay + v) + ax, *pb = b.row(by + v) + bx;
    for (int u = -kHalf; u <= kHalf; ++u) {
      const double p = double(pa[u]), q = double(pb[u]);
      sa += p, sb += q, saa += p * p, sbb += q * q, sab += p * q;
    }
  }
  const double n = (2 * kHalf + 1) * (2 * kHalf + 1);
  const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
  return va > 0 && vb > 0 ? (sab - sa * sb / n) / std::sqrt(va * vb) : 0;
}

// Where the parabola through three values at -1, 0, 1 has its peak.
double peak(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < 0 ? std::clamp((before - after) / (2 * bend), -0.5, 0.5) : 0;
}

struct Shift {
  double x, y;
};

// Where the window of the truth is found in the product, from where it should be.
std::optional<Shift> shift_of(const FloatImage& product, const FloatImage& truth, int x, int y) {
  constexpr int kSide = 2 * kSearch + 1;
  double alike[kSide][kSide], best = -1;
  int best_x = 0, best_y = 0;
  for (int dy = -kSearch; dy <= kSearch; ++dy) {
    for (int dx = -kSearch; dx <= kSearch; ++dx) {
      const double value = alike[dy + kSearch][dx + kSearch] = correlation(truth, x, y, product, x + dx, y + dy);
      if (value > best) best = value, best_x = dx, best_y = dy;
    }
  }
  if (best < kLeastAlike || std::abs(best_x) == kSearch || std::abs(best_y) == kSearch) return std::nullopt;
  const int i = best_x + kSearch, j = best_y + kSearch;
  return Shift{best_x + peak(alike[j][i - 1], best, alike[j][i + 1]),
               best_y + peak(alike[j - 1][i], best, alike[j + 1][i])};
}

OrthoErrors summary_of(const std::vector<Shift>& shifts, std::size_t windows, double cell_m) {
  OrthoErrors errors;
  errors.cell_m = cell_m;
  errors.windows = windows;
  errors.share_failed = 1 - double(shifts.size()) / double(windows);
  if (shifts.empty()) return errors;
  std::vector<double> lengths;
  for (const Shift& s : shifts) {
    errors.mean_x_px += s.x, errors.mean_y_px += s.y;
    errors.rms_x_px += s.x * s.x, errors.rms_y_px += s.y * s.y;
    lengths.push_back(std::hypot(s.x, s.y));
    errors.share_over_1_px += lengths.back() > 1;
  }
  const auto n = double(shifts.size());
  errors.mean_x_px /= n, errors.mean_y_px /= n, errors.share_over_1_px /= n;
  errors.rms_x_px = std::sqrt(errors.rms_x_px / n), errors.rms_y_px = std::sqrt(errors.rms_y_px / n);
  errors.median_px = median(lengths);
  return errors;
}

}  // namespace

Result<OrthoErrors> ortho_errors(const ImageField& product, const ImageField& truth, const Run& run) {
  constexpr int kReach = kHalf + kSearch + 1;
  std::vector<Shift> shifts;
  std::size_t windows = 0;
  for (int row = kReach; row + kReach < product.grid.height; row += kSpacing) {
    if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
    const int top = row - kReach, height = 2 * kReach + 1;
    COLLINEA_TRY(const FloatImage made, grey_window(product, 0, top, product.grid.width, height));
    COLLINEA_TRY(const FloatImage expected, resampled(truth, product.grid, top, height));
    for (int x = kReach; x + kReach < product.grid.width; x += kSpacing) {
      if (!complete(made, x, kReach, kHalf + kSearch) || !complete(expected, x, kReach, kHalf + 1)) continue;
      if (!textured(expected, x, kReach)) continue;
      ++windows;
      if (const auto shift = shift_of(made, expected, x, kReach)) shifts.push_back(*shift);
    }
  }
  if (windows == 0) return fail(Errc::kBadInput, "the orthophoto and the true one have no textured area in common");
  return summary_of(shifts, windows, product.grid.cell_m);
}

}  // namespace collinea
