// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/area_kernels.h"

// The narrowest x86 target is not worth its code.
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/match/internal/area_kernels.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kBlock = 4;  // vectors whose sums stay in registers

using D = hn::CappedTag<std::int32_t, kAreaPadding / kBlock>;
using V = hn::Vec<D>;

// sum + low half of a * low half of b + high half * high half.
HWY_INLINE V with_products([[maybe_unused]] D d, V a, V b, V sum) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR
  const hn::Repartition<std::int16_t, D> d16;
  V unused = hn::Zero(d);
  return hn::ReorderWidenMulAccumulate(d, hn::BitCast(d16, a), hn::BitCast(d16, b), sum, unused);
#else
  const auto low = [&](V v) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(v)); };
  const V high = hn::Mul(hn::ShiftRight<16>(a), hn::ShiftRight<16>(b));
  return hn::Add(sum, hn::Add(hn::Mul(low(a), low(b)), high));
#endif
}

void cross_products(const std::int32_t* pairs, std::ptrdiff_t stride, const std::int32_t* halves, int half_width,
                    int template_rows, int rows, int columns, std::int32_t* out, std::ptrdiff_t out_stride) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; x += kBlock * n) {
      V sum0 = hn::Zero(d), sum1 = hn::Zero(d), sum2 = hn::Zero(d), sum3 = hn::Zero(d);
      for (int v = 0; v < template_rows; ++v) {
        const std::int32_t* searched = pairs + (y + v) * stride + x;
        const std::int32_t* half = halves + v * half_width;
        for (int u = 0; u < half_width; ++u, searched += 2) {
          const V two = hn::Set(d, half[u]);
          sum0 = with_products(d, hn::LoadU(d, searched), two, sum0);
          sum1 = with_products(d, hn::LoadU(d, searched + n), two, sum1);
          sum2 = with_products(d, hn::LoadU(d, searched + 2 * n), two, sum2);
          sum3 = with_products(d, hn::LoadU(d, searched + 3 * n), two, sum3);
        }
      }
      std::int32_t* to = out + y * out_stride + x;
      hn::StoreU(sum0, d, to);
      hn::StoreU(sum1, d, to + n);
      hn::StoreU(sum2, d, to + 2 * n);
      hn::StoreU(sum3, d, to + 3 * n);
    }
  }
}

void correlations(const std::int32_t* products, const std::int32_t* sums, const std::int32_t* squares,
                  std::size_t count, double n, double template_sum, double spread, float* out, float* deviations) {
  const hn::ScalableTag<double> d;
  const hn::Rebind<std::int32_t, decltype(d)> di;
  const hn::Rebind<float, decltype(d)> df;
  const auto pixels = hn::Set(d, n), of_template = hn::Set(d, template_sum), scale = hn::Set(d, spread),
             to_square = hn::Set(d, spread > 0 ? 1 / (spread * n) : 0);
  const auto one = [&](std::size_t i) {
    const auto product = hn::PromoteTo(d, hn::LoadU(di, products + i)), sum = hn::PromoteTo(d, hn::LoadU(di, sums + i)),
               square = hn::PromoteTo(d, hn::LoadU(di, squares + i));
    const auto common = hn::Sub(hn::Mul(pixels, product), hn::Mul(sum, of_template));
    const auto variance = hn::Mul(hn::Sub(hn::Mul(pixels, square), hn::Mul(sum, sum)), scale);
    const auto is_textured = hn::Gt(variance, hn::Zero(d));
    const auto safe = hn::IfThenElse(is_textured, variance, hn::Set(d, 1.0));
    hn::StoreU(hn::DemoteTo(df, hn::IfThenElseZero(is_textured, hn::Div(common, hn::Sqrt(safe)))), df, out + i);
    hn::StoreU(hn::DemoteTo(df, hn::Sqrt(hn::Mul(variance, to_square))), df, deviations + i);
  };
  const std::size_t lanes = hn::Lanes(d);
  for (std::size_t i = 0; i < count; i += lanes) one(i);  // arrays are padded
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(cross_products);
HWY_EXPORT(correlations);

void cross_products(const std::int32_t* pairs, std::ptrdiff_t stride, const std::int32_t* halves, int half_width,
                    int template_rows, int rows, int columns, std::int32_t* out, std::ptrdiff_t out_stride) {
  HWY_DYNAMIC_DISPATCH(cross_products)
  (pairs, stride, halves, half_width, template_rows, rows, columns, out, out_stride);
}

void correlations(const std::int32_t* products, const std::int32_t* sums, const std::int32_t* squares,
                  std::size_t count, double n, double template_sum, double spread, float* out, float* deviations) {
  HWY_DYNAMIC_DISPATCH(correlations)(products, sums, squares, count, n, template_sum, spread, out, deviations);
}

}  // namespace collinea
#endif  // HWY_ONCE
