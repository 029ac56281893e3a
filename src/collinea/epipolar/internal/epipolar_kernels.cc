// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/epipolar_kernels.h"

// The narrowest x86 target is not worth its code.
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/epipolar/internal/epipolar_kernels.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// a x + b y + c.
template <class V>
HWY_INLINE V linear(V a, V x, V b, V y, V c) {
  return hn::Add(hn::Add(hn::Mul(a, x), hn::Mul(b, y)), c);
}

// From pair `begin` as far as whole vectors go; answers where that is.
template <bool kVaries, class D>
HWY_INLINE int sampson(D d, const std::array<double, 9>& matrix, const PairRows& pairs, int begin, int count,
                       const SquaredPixels& pixels, double* out) {
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto m00 = hn::Set(d, matrix[0]), m01 = hn::Set(d, matrix[1]), m02 = hn::Set(d, matrix[2]);
  const auto m10 = hn::Set(d, matrix[3]), m11 = hn::Set(d, matrix[4]), m12 = hn::Set(d, matrix[5]);
  const auto m20 = hn::Set(d, matrix[6]), m21 = hn::Set(d, matrix[7]), m22 = hn::Set(d, matrix[8]);
  auto first = hn::Set(d, *pixels.first), second = hn::Set(d, *pixels.second);
  int i = begin;
  for (; i + lanes <= count; i += lanes) {
    const auto x1 = hn::LoadU(d, pairs.x1 + i), y1 = hn::LoadU(d, pairs.y1 + i);
    const auto x2 = hn::LoadU(d, pairs.x2 + i), y2 = hn::LoadU(d, pairs.y2 + i);
    const auto a = linear(m00, x1, m01, y1, m02), b = linear(m10, x1, m11, y1, m12);
    const auto u = linear(m00, x2, m10, y2, m20), v = linear(m01, x2, m11, y2, m21);
    const auto c = linear(x2, a, y2, b, linear(m20, x1, m21, y1, m22));
    if constexpr (kVaries) first = hn::LoadU(d, pixels.first + i), second = hn::LoadU(d, pixels.second + i);
    const auto in_second = hn::Mul(second, hn::Add(hn::Mul(a, a), hn::Mul(b, b)));
    const auto in_first = hn::Mul(first, hn::Add(hn::Mul(u, u), hn::Mul(v, v)));
    hn::StoreU(hn::Div(hn::Mul(c, c), hn::Add(in_second, in_first)), d, out + i);
  }
  return i;
}

template <bool kVaries>
HWY_INLINE void all(const std::array<double, 9>& matrix, const PairRows& pairs, int count, const SquaredPixels& pixels,
                    double* out) {
  const int rest = sampson<kVaries>(hn::ScalableTag<double>(), matrix, pairs, 0, count, pixels, out);
  sampson<kVaries>(hn::CappedTag<double, 1>(), matrix, pairs, rest, count, pixels, out);
}

void SampsonDistances(const std::array<double, 9>& matrix, const PairRows& pairs, int count,
                      const SquaredPixels& pixels, double* out) {
  return pixels.varies ? all<true>(matrix, pairs, count, pixels, out) : all<false>(matrix, pairs, count, pixels, out);
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(SampsonDistances);

void sampson_distances(const std::array<double, 9>& matrix, const PairRows& pairs, int count,
                       const SquaredPixels& pixels, double* out) {
  HWY_DYNAMIC_DISPATCH(SampsonDistances)(matrix, pairs, count, pixels, out);
}

}  // namespace collinea
#endif
