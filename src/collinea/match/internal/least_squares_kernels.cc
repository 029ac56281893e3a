// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/least_squares_kernels.h"

// The narrowest x86 target is not worth its code.
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/match/internal/least_squares_kernels.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

// Products and sums are kept apart (no fused multiply-add), and sums are kept in kSums parts whatever the width of the
// vectors: then every processor gives the same bits.

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int kSums = 16;

using D = hn::CappedTag<float, kSums>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;

// The four weights of cubic convolution at t of the way from the second point to the third.
struct Weights {
  V of[4];
};

HWY_INLINE Weights weights(D d, V t) {
  const V half = hn::Set(d, 0.5f), t2 = hn::Mul(t, t), t3 = hn::Mul(t2, t);
  const V h = hn::Mul(half, t), h2 = hn::Mul(half, t2), h3 = hn::Mul(half, t3);
  const V three = hn::Set(d, 3.0f), five = hn::Set(d, 5.0f);
  return {{hn::Sub(hn::Sub(t2, h3), h),                                                // -t3/2 + t2 - t/2
           hn::Add(hn::Sub(hn::Mul(three, h3), hn::Mul(five, h2)), hn::Set(d, 1.0f)),  // 3/2 t3 - 5/2 t2 + 1
           hn::Add(hn::Sub(hn::Mul(hn::Set(d, 2.0f), t2), hn::Mul(three, h3)), h),     // -3/2 t3 + 2 t2 + t/2
           hn::Sub(h3, h2)}};                                                          // t3/2 - t2/2
}

template <int kByte>
HWY_INLINE V byte_of(D d, DI di, VI four) {
  return hn::ConvertTo(d, hn::And(hn::ShiftRight<8 * kByte>(four), hn::Set(di, 255)));
}

bool sample_window(const GreySquare& square, const WindowPosition& position, const float* u, const float* v,
                   float* out) {
  const D d;
  const DI di;
  const int n = static_cast<int>(hn::Lanes(d));
  const VI least = hn::Set(di, 1), most = hn::Set(di, square.size - 3), stride = hn::Set(di, square.size);
  const auto* base = reinterpret_cast<const std::int32_t*>(square.grey);
  for (int i = 0; i < kWindowFloats; i += n) {
    const V ui = hn::LoadU(d, u + i), vi = hn::LoadU(d, v + i);
    const V x = hn::Add(hn::Set(d, position.x),
                        hn::Add(hn::Mul(hn::Set(d, position.xu), ui), hn::Mul(hn::Set(d, position.xv), vi)));
    const V y = hn::Add(hn::Set(d, position.y),
                        hn::Add(hn::Mul(hn::Set(d, position.yu), ui), hn::Mul(hn::Set(d, position.yv), vi)));
    const V x_low = hn::Floor(x), y_low = hn::Floor(y);
    const VI column = hn::ConvertTo(di, x_low), row = hn::ConvertTo(di, y_low);
    const auto outside =
        hn::Or(hn::Or(hn::Lt(column, least), hn::Gt(column, most)), hn::Or(hn::Lt(row, least), hn::Gt(row, most)));
    if (!hn::AllFalse(di, outside)) return false;
    const Weights across = weights(d, hn::Sub(x, x_low)), down = weights(d, hn::Sub(y, y_low));
    VI at = hn::Sub(hn::Add(hn::Mul(hn::Sub(row, least), stride), column), least);
    V sum = hn::Zero(d);
    for (int j = 0; j < 4; ++j) {
      const VI four = hn::GatherOffset(di, base, at);
      const V left =
          hn::Add(hn::Mul(across.of[0], byte_of<0>(d, di, four)), hn::Mul(across.of[1], byte_of<1>(d, di, four)));
      const V right =
          hn::Add(hn::Mul(across.of[2], byte_of<2>(d, di, four)), hn::Mul(across.of[3], byte_of<3>(d, di, four)));
      sum = hn::Add(sum, hn::Mul(down.of[j], hn::Add(left, right)));
      at = hn::Add(at, stride);
    }
    hn::StoreU(sum, d, out + i);
  }
  return true;
}

void window_products(const float* columns, const float* values, float* out) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  HWY_ALIGN float sums[kUnknowns][kSums] = {};
  for (int i = 0; i < kWindowFloats; i += kSums)
    for (int part = 0; part < kSums; part += n) {
      const V value = hn::LoadU(d, values + i + part);
      for (int k = 0; k < kUnknowns; ++k) {
        const V product = hn::Mul(hn::LoadU(d, columns + k * kWindowFloats + i + part), value);
        hn::Store(hn::Add(hn::Load(d, sums[k] + part), product), d, sums[k] + part);
      }
    }
  for (int k = 0; k < kUnknowns; ++k) {
    out[k] = 0;
    for (const float sum : sums[k]) out[k] += sum;
  }
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(sample_window);
HWY_EXPORT(window_products);

bool sample_window(const GreySquare& square, const WindowPosition& position, const float* u, const float* v,
                   float* out) {
  return HWY_DYNAMIC_DISPATCH(sample_window)(square, position, u, v, out);
}

void window_products(const float* columns, const float* values, float* out) {
  HWY_DYNAMIC_DISPATCH(window_products)(columns, values, out);
}

}  // namespace collinea
#endif  // HWY_ONCE
