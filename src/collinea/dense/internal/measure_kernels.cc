// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/measure_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/internal/measure_kernels.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::Rebind<std::int32_t, F>;
constexpr F f;
constexpr I i32;

constexpr int kSide = 2 * kMeasureReach + 1;
constexpr float kPixels = float(kSide * kSide);
constexpr int kPerPixel = 16;  // positions and grey values are multiples of 1/16
constexpr float kTrialPx = 0.5f;
constexpr float kFlat = 0.02f * kPixels;  // sum of squares below which a window is without texture

void PackQuads(const std::uint8_t* row, int width, std::int32_t* HWY_RESTRICT quads) {
  const hn::Rebind<std::uint8_t, F> u8;
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    const auto at = [&](int i) { return hn::PromoteTo(i32, hn::LoadU(u8, row + x + i)); };
    const auto lower = hn::Or(at(-1), hn::ShiftLeft<8>(at(0)));
    hn::StoreU(hn::Or(lower, hn::Or(hn::ShiftLeft<16>(at(1)), hn::ShiftLeft<24>(at(2)))), i32, quads + x);
  }
}

// Position [1/16 px] of column x on the right image: the surface there, rounded.
HWY_INLINE hn::Vec<I> PositionOf(const float* surface, int x) {
  const auto column = hn::Add(hn::Iota(f, 0), hn::Set(f, float(x)));
  const auto position = hn::Mul(hn::Sub(column, hn::LoadU(f, surface + x)), hn::Set(f, float(kPerPixel)));
  return hn::NearestInt(position);
}

void Warp(const std::uint8_t* left, const std::int32_t* quads, int right_width, const float* surface, int width,
          const TrialRow& out) {
  const hn::Rebind<std::uint8_t, F> u8;
  const auto byte = hn::Set(i32, 0xFF), middle = hn::Set(i32, 128 * kPerPixel), zero = hn::Zero(i32);
  const auto half = hn::Set(i32, kPerPixel / 2);
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    const auto own = hn::PromoteTo(i32, hn::LoadU(u8, left + x));
    const auto position = PositionOf(surface, x);
    const auto column = hn::Min(hn::Max(hn::ShiftRight<4>(position), zero), hn::Set(i32, right_width - 1));
    const auto part = hn::And(position, hn::Set(i32, kPerPixel - 1));
    const auto quad = hn::GatherIndex(i32, quads, column);
    const auto a = hn::And(quad, byte), b = hn::And(hn::ShiftRight<8>(quad), byte);
    const auto c = hn::And(hn::ShiftRight<16>(quad), byte), e = hn::And(hn::ShiftRight<24>(quad), byte);
    const auto between = [&](auto from, auto to, auto weight) {
      return hn::Sub(hn::Add(hn::ShiftLeft<4>(from), hn::Mul(hn::Sub(to, from), weight)), middle);
    };
    const auto first_half = hn::Lt(part, half);
    // a larger disparity lies farther to the left
    const auto less =
        hn::IfThenElse(first_half, between(b, c, hn::Add(part, half)), between(c, e, hn::Sub(part, half)));
    const auto more =
        hn::IfThenElse(first_half, between(a, b, hn::Add(part, half)), between(b, c, hn::Sub(part, half)));
    hn::StoreU(less, i32, out.right[0] + x);
    hn::StoreU(between(b, c, part), i32, out.right[1] + x);
    hn::StoreU(more, i32, out.right[2] + x);
    hn::StoreU(hn::Sub(own, hn::Set(i32, 128)), i32, out.left + x);
    const auto least = hn::Min(own, hn::Min(hn::Min(a, b), hn::Min(c, e)));
    hn::StoreU(hn::VecFromMask(i32, hn::Eq(least, zero)), i32, out.missing + x);
  }
}

template <bool kLeaving>
HWY_INLINE void SlideBy(const TrialRow& entering, const TrialRow& leaving, int width, const ColumnSums& sums) {
  for (int x = 0; x < width; x += int(hn::Lanes(i32))) {
    const auto update = [&](std::int32_t* sum, auto in, auto out) {
      auto value = hn::Add(hn::LoadU(i32, sum + x), in);
      if constexpr (kLeaving) value = hn::Sub(value, out);
      hn::StoreU(value, i32, sum + x);
    };
    const auto in = hn::LoadU(i32, entering.left + x), out = hn::LoadU(i32, leaving.left + x);
    update(sums.left, in, out);
    update(sums.left_left, hn::Mul(in, in), hn::Mul(out, out));
    update(sums.missing, hn::LoadU(i32, entering.missing + x), hn::LoadU(i32, leaving.missing + x));
    for (std::size_t t = 0; t < kMeasureTrials; ++t) {
      const auto right_in = hn::LoadU(i32, entering.right[t] + x), right_out = hn::LoadU(i32, leaving.right[t] + x);
      update(sums.right[t], right_in, right_out);
      update(sums.right_right[t], hn::Mul(right_in, right_in), hn::Mul(right_out, right_out));
      update(sums.left_right[t], hn::Mul(in, right_in), hn::Mul(out, right_out));
    }
  }
}

void Slide(const TrialRow& entering, const TrialRow* leaving, int width, const ColumnSums& sums) {
  if (leaving)
    SlideBy<true>(entering, *leaving, width, sums);
  else
    SlideBy<false>(entering, entering, width, sums);
}

HWY_INLINE hn::Vec<F> AcrossWindow(const std::int32_t* columns, int x) {
  auto sum = hn::LoadU(i32, columns + x);
  for (int i = 1; i < kSide; ++i) sum = hn::Add(sum, hn::LoadU(i32, columns + x + i));
  return hn::ConvertTo(f, sum);
}

void Peaks(const ColumnSums& sums, int width, const MeasuredRow& row) {
  const auto part = hn::Set(f, 1 / kPixels), zero = hn::Zero(f), one = hn::Set(f, 1.0f);
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    const auto left = AcrossWindow(sums.left, x);
    const auto own = hn::Sub(AcrossWindow(sums.left_left, x), hn::Mul(hn::Mul(left, left), part));
    const auto missing = hn::Lt(AcrossWindow(sums.missing, x), zero);
    hn::Vec<F> rho[kMeasureTrials];
    for (std::size_t t = 0; t < kMeasureTrials; ++t) {
      const auto right = AcrossWindow(sums.right[t], x);
      const auto other = hn::Sub(AcrossWindow(sums.right_right[t], x), hn::Mul(hn::Mul(right, right), part));
      const auto both = hn::Sub(AcrossWindow(sums.left_right[t], x), hn::Mul(hn::Mul(left, right), part));
      const auto flat =
          hn::Or(hn::Lt(own, hn::Set(f, kFlat)), hn::Lt(other, hn::Set(f, kFlat * kPerPixel * kPerPixel)));
      const auto value = hn::Div(both, hn::Sqrt(hn::Mul(own, other)));
      rho[t] = hn::IfThenElse(hn::Or(flat, missing), zero, value);
    }
    const auto curvature = hn::Sub(hn::Sub(hn::Add(rho[1], rho[1]), rho[0]), rho[2]);
    const auto rises = hn::Sub(rho[2], rho[0]);
    const auto peaked = hn::Gt(curvature, hn::Set(f, 1e-6f));
    const auto safe = hn::IfThenElse(peaked, curvature, one);
    const auto off = hn::Min(hn::Max(hn::Div(hn::Mul(rises, hn::Set(f, 0.5f)), safe), hn::Set(f, -1.0f)), one);
    const auto highest = hn::Min(hn::Add(rho[1], hn::Mul(hn::Mul(rises, hn::Set(f, 0.25f)), off)), one);
    // least squares matching of two images, both of them noisy: residuals over squared gradients
    const auto residual = hn::Add(hn::Sub(one, highest), hn::Set(f, 1e-4f));
    const auto variance = hn::Div(hn::Mul(residual, hn::Set(f, 2 * kTrialPx * kTrialPx / kPixels)), safe);
    const auto column = hn::Add(hn::Iota(f, 0), hn::Set(f, float(x)));
    const auto position = hn::Mul(hn::ConvertTo(f, PositionOf(row.surface, x)), hn::Set(f, 1.0f / kPerPixel));
    const auto middle = hn::Sub(column, position);
    const auto moved = hn::Add(middle, hn::Mul(off, hn::Set(f, kTrialPx)));
    hn::StoreU(hn::IfThenElse(peaked, moved, middle), f, row.disparity + x);
    hn::StoreU(hn::IfThenElse(peaked, hn::Sqrt(variance), hn::Inf(f)), f, row.sigma + x);
    hn::StoreU(hn::IfThenElse(peaked, highest, rho[1]), f, row.correlation + x);
  }
}

void AcceptRow(const float* found, const Acceptance& a, int width, const MeasuredRow& row) {
  const auto floor = hn::Set(f, a.sigma_floor_px * a.sigma_floor_px);
  const auto of_surface = hn::Set(f, a.surface_sigma_px * a.surface_sigma_px);
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    const auto own = hn::Mul(hn::Set(f, a.sigma_scale), hn::LoadU(f, row.sigma + x));
    const auto sigma = hn::Sqrt(hn::Add(hn::Mul(own, own), floor));
    const auto before = hn::LoadU(f, found + x);
    const auto good = hn::And(hn::Ge(hn::LoadU(f, row.correlation + x), hn::Set(f, a.min_correlation)),
                              hn::Le(sigma, hn::Set(f, a.max_sigma_px)));
    const auto accepted = hn::And(good, hn::Eq(before, before));
    const auto part = hn::Div(of_surface, hn::Add(of_surface, hn::Mul(sigma, sigma)));
    const auto surface = hn::LoadU(f, row.surface + x);
    const auto both = hn::Add(surface, hn::Mul(part, hn::Sub(hn::LoadU(f, row.disparity + x), surface)));
    hn::StoreU(hn::IfThenElse(accepted, both, hn::NaN(f)), f, row.disparity + x);
    hn::StoreU(hn::IfThenElse(accepted, sigma, hn::NaN(f)), f, row.sigma + x);
  }
}

HWY_INLINE void Order(hn::Vec<F>& a, hn::Vec<F>& b) {
  const auto low = hn::Min(a, b);
  b = hn::Max(a, b);
  a = low;
}

void MedianRow(const std::array<const float*, 3>& rows, int width, float* out) {
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    hn::Vec<F> v[9];
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) v[3 * j + i] = hn::LoadU(f, rows[std::size_t(j)] + x + i - 1);
    const auto sort = [&](int a, int b) { Order(v[a], v[b]); };
    // the network of Devillard (1998)
    sort(1, 2), sort(4, 5), sort(7, 8), sort(0, 1), sort(3, 4), sort(6, 7), sort(1, 2), sort(4, 5), sort(7, 8);
    sort(0, 3), sort(5, 8), sort(4, 7), sort(3, 6), sort(1, 4), sort(2, 5), sort(4, 7), sort(4, 2), sort(6, 4);
    sort(4, 2);
    hn::StoreU(v[4], f, out + x);
  }
}

void MedianOfKnownRow(const std::array<const float*, 3>& rows, int width, float* out) {
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    hn::Vec<F> v[9];
    auto known = hn::Zero(i32);  // less the number of those
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        const auto value = hn::LoadU(f, rows[std::size_t(j)] + x + i - 1);
        const auto is_known = hn::Eq(value, value);
        v[3 * j + i] = hn::IfThenElse(is_known, value, hn::Inf(f));  // to the end
        known = hn::Add(known, hn::BitCast(i32, hn::VecFromMask(f, is_known)));
      }
    const auto sort = [&](int a, int b) { Order(v[a], v[b]); };
    // a network that sorts nine (Floyd, in Knuth 1973)
    sort(0, 3), sort(1, 7), sort(2, 5), sort(4, 8), sort(0, 7), sort(2, 4), sort(3, 8), sort(5, 6), sort(0, 2);
    sort(1, 3), sort(4, 5), sort(7, 8), sort(1, 4), sort(3, 6), sort(5, 7), sort(0, 1), sort(2, 4), sort(3, 5);
    sort(6, 8), sort(2, 3), sort(4, 5), sort(6, 7), sort(1, 2), sort(3, 4), sort(5, 6);
    auto median = v[4];
    for (int n = 0; n < 8; ++n)
      median = hn::IfThenElse(hn::RebindMask(f, hn::Eq(known, hn::Set(i32, -n))), v[n / 2], median);
    median = hn::IfThenElse(hn::RebindMask(f, hn::Eq(known, hn::Zero(i32))), hn::NaN(f), median);
    hn::StoreU(median, f, out + x);
  }
}

void MeanWithinRow(const std::array<const float*, 5>& rows, float reach, int width, float* out) {
  const auto limit = hn::Set(f, reach);
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    const auto middle = hn::LoadU(f, rows[2] + x);
    auto sum = hn::Zero(f), count = hn::Zero(f);
    for (std::size_t j = 0; j < 5; ++j)
      for (int i = -2; i <= 2; ++i) {
        const auto off = hn::Sub(hn::LoadU(f, rows[j] + x + i), middle);
        const auto near = hn::Le(hn::Abs(off), limit);
        sum = hn::Add(sum, hn::IfThenElseZero(near, off));
        count = hn::Add(count, hn::IfThenElseZero(near, hn::Set(f, 1.0f)));
      }
    const auto mean = hn::Add(middle, hn::Div(sum, count));
    hn::StoreU(hn::IfThenElse(hn::Gt(count, hn::Zero(f)), mean, middle), f, out + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {

HWY_EXPORT(PackQuads);
HWY_EXPORT(Warp);
HWY_EXPORT(Slide);
HWY_EXPORT(Peaks);
HWY_EXPORT(AcceptRow);
HWY_EXPORT(MedianRow);
HWY_EXPORT(MedianOfKnownRow);
HWY_EXPORT(MeanWithinRow);

void pack_quads(const std::uint8_t* row, int width, std::int32_t* quads) {
  HWY_DYNAMIC_DISPATCH(PackQuads)(row, width, quads);
}
void warp_row(const std::uint8_t* left, const std::int32_t* quads, int right_width, const float* surface, int width,
              const TrialRow& out) {
  HWY_DYNAMIC_DISPATCH(Warp)(left, quads, right_width, surface, width, out);
}
void slide(const TrialRow& entering, const TrialRow* leaving, int width, const ColumnSums& sums) {
  HWY_DYNAMIC_DISPATCH(Slide)(entering, leaving, width, sums);
}
void find_peaks(const ColumnSums& sums, int width, const MeasuredRow& row) {
  HWY_DYNAMIC_DISPATCH(Peaks)(sums, width, row);
}
void accept_row(const float* found, const Acceptance& acceptance, int width, const MeasuredRow& row) {
  HWY_DYNAMIC_DISPATCH(AcceptRow)(found, acceptance, width, row);
}
void median_row(const std::array<const float*, 3>& rows, int width, float* out) {
  HWY_DYNAMIC_DISPATCH(MedianRow)(rows, width, out);
}
void median_of_known_row(const std::array<const float*, 3>& rows, int width, float* out) {
  HWY_DYNAMIC_DISPATCH(MedianOfKnownRow)(rows, width, out);
}
void mean_within_row(const std::array<const float*, 5>& rows, float reach, int width, float* out) {
  HWY_DYNAMIC_DISPATCH(MeanWithinRow)(rows, reach, width, out);
}

}  // namespace collinea::dense
#endif  // HWY_ONCE
