// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/sift_kernels.h"

#include <cmath>
#include <cstring>
#include <numbers>

// The narrowest x86 target is not worth its code.
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/feature/internal/sift_kernels.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;

void widen_row(const std::uint8_t* in, int width, float* out) {
  for (int x = 0; x < width; ++x) out[x] = in[x];
}

void filter_along_row(const float* in, int width, const float* taps, int radius, float* out) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < width; x += 2 * n) {
    const V centre = hn::Set(d, taps[0]);
    V left = hn::Mul(centre, hn::LoadU(d, in + x)), right = hn::Mul(centre, hn::LoadU(d, in + x + n));
    for (int j = 1; j <= radius; ++j) {
      const V tap = hn::Set(d, taps[j]);
      left = hn::MulAdd(tap, hn::Add(hn::LoadU(d, in + x - j), hn::LoadU(d, in + x + j)), left);
      right = hn::MulAdd(tap, hn::Add(hn::LoadU(d, in + x + n - j), hn::LoadU(d, in + x + n + j)), right);
    }
    hn::StoreU(left, d, out + x);
    hn::StoreU(right, d, out + x + n);
  }
}

void filter_across_rows(const float* const* rows, int width, const float* taps, int radius, float* out) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  const float* const* middle = rows + radius;
  for (int x = 0; x < width; x += 2 * n) {
    const V centre = hn::Set(d, taps[0]);
    V left = hn::Mul(centre, hn::LoadU(d, middle[0] + x)), right = hn::Mul(centre, hn::LoadU(d, middle[0] + x + n));
    for (int j = 1; j <= radius; ++j) {
      const V tap = hn::Set(d, taps[j]);
      const float *above = middle[-j] + x, *below = middle[j] + x;
      left = hn::MulAdd(tap, hn::Add(hn::LoadU(d, above), hn::LoadU(d, below)), left);
      right = hn::MulAdd(tap, hn::Add(hn::LoadU(d, above + n), hn::LoadU(d, below + n)), right);
    }
    hn::StoreU(left, d, out + x);
    hn::StoreU(right, d, out + x + n);
  }
}

void subtract_rows(const float* a, const float* b, int width, float* out) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < width; x += n) hn::StoreU(hn::Sub(hn::LoadU(d, a + x), hn::LoadU(d, b + x)), d, out + x);
}

int extrema_of_row(const float* const* rows, int begin, int end, float threshold, std::int32_t* found) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  const V least = hn::Set(d, threshold);
  constexpr int kOrder[9] = {4, 3, 5, 1, 7, 0, 2, 6, 8};  // the same plane's rows come early: they decide most often
  int count = 0;
  for (int x = begin; x < end; x += n) {
    const V value = hn::LoadU(d, rows[4] + x);
    auto is_peak = hn::Gt(value, least), is_pit = hn::Lt(value, hn::Neg(least));
    if (hn::AllFalse(d, hn::Or(is_peak, is_pit))) continue;
    bool any = true;
    for (int k = 0; k < 9 && any; ++k) {
      const float* row = rows[kOrder[k]] + x;
      const V before = hn::LoadU(d, row - 1), after = hn::LoadU(d, row + 1);
      V largest = hn::Max(before, after), smallest = hn::Min(before, after);
      if (kOrder[k] != 4) {
        const V at = hn::LoadU(d, row);
        largest = hn::Max(largest, at);
        smallest = hn::Min(smallest, at);
      }
      is_peak = hn::And(is_peak, hn::Ge(value, largest));
      is_pit = hn::And(is_pit, hn::Le(value, smallest));
      any = !hn::AllFalse(d, hn::Or(is_peak, is_pit));
    }
    if (!any) continue;
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::Or(is_peak, is_pit), bits);
    for (int i = 0; i < n && x + i < end; ++i)
      if (bits[i / 8] >> (i % 8) & 1) found[count++] = x + i;
  }
  return count;
}

// The gradient (times two) at the pixels from p on: its size and its direction in turns, in [0, 1].
HWY_INLINE void gradient(D d, const float* p, std::ptrdiff_t stride, V* size, V* turns) {
  const V dx = hn::Sub(hn::LoadU(d, p + 1), hn::LoadU(d, p - 1));
  const V dy = hn::Sub(hn::LoadU(d, p + stride), hn::LoadU(d, p - stride));
  *size = hn::Sqrt(hn::MulAdd(dx, dx, hn::Mul(dy, dy)));
  const V ax = hn::Abs(dx), ay = hn::Abs(dy);
  const V ratio = hn::Div(hn::Min(ax, ay), hn::Max(hn::Max(ax, ay), hn::Set(d, 1e-20f)));
  const V square = hn::Mul(ratio, ratio);
  // atan(ratio) / 2 pi on [0, 1]; error < 1.2e-5 rad.
  V sum = hn::Set(d, 0.0033176f);
  sum = hn::MulAdd(sum, square, hn::Set(d, -0.01355304f));
  sum = hn::MulAdd(sum, square, hn::Set(d, 0.02867324f));
  sum = hn::MulAdd(sum, square, hn::Set(d, -0.05256964f));
  sum = hn::MulAdd(sum, square, hn::Set(d, 0.15913367f));
  V angle = hn::Mul(sum, ratio);
  angle = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(hn::Set(d, 0.25f), angle), angle);
  angle = hn::IfThenElse(hn::Lt(dx, hn::Zero(d)), hn::Sub(hn::Set(d, 0.5f), angle), angle);
  *turns = hn::IfThenElse(hn::Lt(dy, hn::Zero(d)), hn::Sub(hn::Set(d, 1.0f), angle), angle);
}

constexpr int kMaxWindow = 160;  // pixels across the largest window, with room for a vector more

// weights[i] = exp(-(first + i - centre)^2 / (2 sigma^2)). By recurrence: the ratio of neighbours is a geometric
// series.
HWY_INLINE void gaussian_weights(int first, int last, float centre, float sigma, float* weights) {
  const double a = -0.5 / (double{sigma} * sigma), x = first - double{centre};
  double value = std::exp(a * x * x), ratio = std::exp(a * (2 * x + 1));
  const double step = std::exp(2 * a);
  for (int i = 0; i <= last - first; ++i) {
    weights[i] = static_cast<float>(value);
    value *= ratio;
    ratio *= step;
  }
}

void direction_histogram(const BlurredImage& image, float x, float y, float sigma, float* histogram) {
  const D d;
  const DI di;
  const int n = static_cast<int>(hn::Lanes(d));
  const float radius = 3 * sigma;
  const int x0 = HWY_MAX(1, static_cast<int>(std::ceil(x - radius)));
  const int x1 = HWY_MIN(image.width - 2, static_cast<int>(std::floor(x + radius)));
  const int y0 = HWY_MAX(1, static_cast<int>(std::ceil(y - radius)));
  const int y1 = HWY_MIN(image.height - 2, static_cast<int>(std::floor(y + radius)));
  float weights_x[kMaxWindow] = {}, weights_y[kMaxWindow];
  gaussian_weights(x0, x1, x, sigma, weights_x);
  gaussian_weights(y0, y1, y, sigma, weights_y);

  float bins[2][kDirectionBins + 2] = {};  // two, so that neighbouring pixels do not wait for each other
  HWY_ALIGN std::int32_t bin[kMaxWindow];
  HWY_ALIGN float fraction[kMaxWindow], weight[kMaxWindow];
  for (int row = y0; row <= y1; ++row) {
    const float half = std::sqrt(HWY_MAX(0.0f, radius * radius - (row - y) * (row - y)));
    const int begin = HWY_MAX(x0, static_cast<int>(std::ceil(x - half)));
    const int count = HWY_MIN(x1, static_cast<int>(std::floor(x + half))) - begin + 1;
    const float* pixels = image.data + (row - image.first_row) * image.stride + begin;
    for (int i = 0; i < count; i += n) {
      V size, turns;
      gradient(d, pixels + i, image.stride, &size, &turns);
      const V position = hn::Mul(turns, hn::Set(d, float{kDirectionBins}));
      const auto whole = hn::ConvertTo(di, position);
      hn::Store(whole, di, bin + i);
      hn::Store(hn::Sub(position, hn::ConvertTo(d, whole)), d, fraction + i);
      hn::Store(hn::Mul(size, hn::LoadU(d, weights_x + (begin - x0) + i)), d, weight + i);
    }
    for (int i = 0; i < count; ++i) {
      const float all = weight[i] * weights_y[row - y0], upper = all * fraction[i];
      float* at = bins[i & 1] + bin[i];
      at[0] += all - upper;
      at[1] += upper;
    }
  }
  for (int b = 0; b < kDirectionBins; ++b) histogram[b] = bins[0][b] + bins[1][b];
  for (int b = 0; b < 2; ++b) histogram[b] += bins[0][kDirectionBins + b] + bins[1][kDirectionBins + b];
}

// The whole numbers in [*begin, *end] at which |slope (i - centre) + offset| < half.
HWY_INLINE void clip_to_band(float slope, float offset, float half, float centre, int* begin, int* end) {
  if (std::abs(slope) < 1e-6f) {
    if (std::abs(offset) >= half) *end = *begin - 1;
    return;
  }
  const float a = (-half - offset) / slope, b = (half - offset) / slope;
  *begin = HWY_MAX(*begin, static_cast<int>(std::ceil(centre + HWY_MIN(a, b))));
  *end = HWY_MIN(*end, static_cast<int>(std::floor(centre + HWY_MAX(a, b))));
}

constexpr int kCells = 4, kDirections = 8;
constexpr int kGridCells = kCells + 2;  // one more on each side takes what falls outside
constexpr int kGridDirections =
    kDirections + 2;  // one more takes what belongs to the first again; one for its neighbour
constexpr int kGridRow = kGridCells * kGridDirections;
constexpr int kGridSize = kGridCells * kGridRow;
constexpr float kHalfPatch = 0.5f * (kCells + 1);  // cells from the middle to where the weight of the outer cells ends

// What each pixel of a stretch of a row gives to the histogram of a patch.
struct Shares {
  HWY_ALIGN std::int32_t first_cell[kMaxWindow];  // of the first of its cells and directions in the grid
  HWY_ALIGN float across[kMaxWindow];             // share of the cells to the right of it
  HWY_ALIGN float down[kMaxWindow];               // share of the cells below it
  HWY_ALIGN float around[2 * kMaxWindow];         // shares of the direction and of the next one
  HWY_ALIGN float weight[kMaxWindow];
};

// Adds `part` times the two shares to two neighbouring bins.
HWY_INLINE void add_two(float* bins, float part, const float* shares) {
#if HWY_TARGET == HWY_SCALAR
  bins[0] += part * shares[0];
  bins[1] += part * shares[1];
#else
  const hn::CappedTag<float, 2> d;
  hn::StoreU(hn::MulAdd(hn::Set(d, part), hn::LoadU(d, shares), hn::LoadU(d, bins)), d, bins);
#endif
}

// Two grids take turns, so that neighbouring pixels do not wait for each other's sums.
HWY_INLINE void scatter(const Shares& shares, int count, float row_weight, float (*grids)[kGridSize]) {
  for (int i = 0; i < count; ++i) {
    const float all = shares.weight[i] * row_weight;
    const float lower = all * shares.down[i], upper = all - lower;
    const float upper_right = upper * shares.across[i], lower_right = lower * shares.across[i];
    float* at = grids[i & 1] + shares.first_cell[i];
    const float* around = shares.around + 2 * i;
    add_two(at, upper - upper_right, around);
    add_two(at + kGridDirections, upper_right, around);
    add_two(at + kGridRow, lower - lower_right, around);
    add_two(at + kGridRow + kGridDirections, lower_right, around);
  }
}

void gradient_patch(const BlurredImage& image, float x, float y, float angle_rad, float cell_px, int row_step,
                    float* histogram) {
  const D d;
  const DI di;
  const int n = static_cast<int>(hn::Lanes(d));
  const float c = std::cos(angle_rad) / cell_px, s = std::sin(angle_rad) / cell_px;
  const float radius = kHalfPatch * (std::abs(c) + std::abs(s)) * cell_px * cell_px;
  const int x0 = HWY_MAX(1, static_cast<int>(std::ceil(x - radius)));
  const int x1 = HWY_MIN(image.width - 2, static_cast<int>(std::floor(x + radius)));
  const int y0 = HWY_MAX(1, static_cast<int>(std::ceil(y - radius)));
  const int y1 = HWY_MIN(image.height - 2, static_cast<int>(std::floor(y + radius)));
  float weights_x[kMaxWindow] = {}, weights_y[kMaxWindow];
  const float window_sigma = 0.5f * kCells * cell_px;
  gaussian_weights(x0, x1, x, window_sigma, weights_x);
  gaussian_weights(y0, y1, y, window_sigma, weights_y);
  const V turn = hn::Set(d, angle_rad / (2 * std::numbers::pi_v<float>)), one = hn::Set(d, 1.0f);
  const V last_cell = hn::Set(d, kCells + 1 - 1e-5f), zero = hn::Zero(d);

  float grids[2][kGridSize] = {};
  Shares shares;
  const int phase = (static_cast<int>(std::lround(y)) - y0) % row_step;
  for (int row = y0 + (phase + row_step) % row_step; row <= y1; row += row_step) {
    const float dy = row - y;
    int begin = x0, end = x1;
    clip_to_band(c, s * dy, kHalfPatch, x, &begin, &end);
    clip_to_band(-s, c * dy, kHalfPatch, x, &begin, &end);
    const int count = end - begin + 1;
    const float* pixels = image.data + (row - image.first_row) * image.stride + begin;
    for (int i = 0; i < count; i += n) {
      V size, turns;
      gradient(d, pixels + i, image.stride, &size, &turns);
      const V dx = hn::Add(hn::Iota(d, static_cast<float>(i)), hn::Set(d, begin - x));
      // Where the pixel lies, counted in cells from the centre of the first, outer cell.
      V u = hn::MulAdd(hn::Set(d, c), dx, hn::Set(d, s * dy + kHalfPatch));
      V v = hn::MulAdd(hn::Set(d, -s), dx, hn::Set(d, c * dy + kHalfPatch));
      u = hn::Min(hn::Max(u, zero), last_cell);
      v = hn::Min(hn::Max(v, zero), last_cell);
      V direction = hn::Sub(turns, turn);
      direction = hn::Mul(hn::Sub(direction, hn::Floor(direction)), hn::Set(d, float{kDirections}));
      const auto ui = hn::ConvertTo(di, u), vi = hn::ConvertTo(di, v), oi = hn::ConvertTo(di, direction);
      const auto cell = hn::Add(hn::Mul(vi, hn::Set(di, kGridRow)), hn::Mul(ui, hn::Set(di, kGridDirections)));
      hn::Store(hn::Add(cell, oi), di, shares.first_cell + i);
      hn::Store(hn::Sub(u, hn::ConvertTo(d, ui)), d, shares.across + i);
      hn::Store(hn::Sub(v, hn::ConvertTo(d, vi)), d, shares.down + i);
      const V next = hn::Sub(direction, hn::ConvertTo(d, oi));
      hn::StoreInterleaved2(hn::Sub(one, next), next, d, shares.around + 2 * i);
      hn::Store(hn::Mul(size, hn::LoadU(d, weights_x + (begin - x0) + i)), d, shares.weight + i);
    }
    scatter(shares, count, weights_y[row - y0], grids);
  }
  for (int j = 0; j < kCells; ++j)
    for (int i = 0; i < kCells; ++i) {
      const int from = (j + 1) * kGridRow + (i + 1) * kGridDirections;
      float* to = histogram + (j * kCells + i) * kDirections;
      for (int k = 0; k < kDirections; ++k) to[k] = grids[0][from + k] + grids[1][from + k];
      // A direction just below a full turn may round to it.
      for (int k = 0; k < 2; ++k) to[k] += grids[0][from + kDirections + k] + grids[1][from + kDirections + k];
    }
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(widen_row);
HWY_EXPORT(filter_along_row);
HWY_EXPORT(filter_across_rows);
HWY_EXPORT(subtract_rows);
HWY_EXPORT(extrema_of_row);
HWY_EXPORT(direction_histogram);
HWY_EXPORT(gradient_patch);

void widen_row(const std::uint8_t* in, int width, float* out) { HWY_DYNAMIC_DISPATCH(widen_row)(in, width, out); }

void filter_along_row(const float* in, int width, const float* taps, int radius, float* out) {
  HWY_DYNAMIC_DISPATCH(filter_along_row)(in, width, taps, radius, out);
}

void filter_across_rows(const float* const* rows, int width, const float* taps, int radius, float* out) {
  HWY_DYNAMIC_DISPATCH(filter_across_rows)(rows, width, taps, radius, out);
}

void subtract_rows(const float* a, const float* b, int width, float* out) {
  HWY_DYNAMIC_DISPATCH(subtract_rows)(a, b, width, out);
}

int extrema_of_row(const float* const* rows, int begin, int end, float threshold, std::int32_t* found) {
  return HWY_DYNAMIC_DISPATCH(extrema_of_row)(rows, begin, end, threshold, found);
}

void direction_histogram(const BlurredImage& image, float x, float y, float sigma, float* histogram) {
  HWY_DYNAMIC_DISPATCH(direction_histogram)(image, x, y, sigma, histogram);
}

void gradient_patch(const BlurredImage& image, float x, float y, float angle_rad, float cell_px, int row_step,
                    float* histogram) {
  HWY_DYNAMIC_DISPATCH(gradient_patch)(image, x, y, angle_rad, cell_px, row_step, histogram);
}

}  // namespace collinea
#endif
