// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/interest_kernels.h"

// The narrowest x86 target is not worth its code.
#define HWY_DISABLED_TARGETS HWY_SSSE3
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/feature/internal/interest_kernels.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

// The sum over three rows or columns, the middle one counted `weight` times.
HWY_INLINE V weighted(V first, V middle, V last, V weight) { return hn::MulAdd(weight, middle, hn::Add(first, last)); }

template <GradientMask kMask>
HWY_INLINE void products(const float* above, const float* middle, const float* below, int width, float* xx, float* xy,
                         float* yy) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  const V weight = hn::Set(d, kMask == GradientMask::kSobel ? 2.0f : 1.0f);
  for (int x = 0; x < width; x += n) {
    const auto slope = [&](const float* row) { return hn::Sub(hn::LoadU(d, row + x + 1), hn::LoadU(d, row + x - 1)); };
    const auto fall = [&](int at) { return hn::Sub(hn::LoadU(d, below + x + at), hn::LoadU(d, above + x + at)); };
    V gx = slope(middle), gy = fall(0);
    if constexpr (kMask != GradientMask::kCentral) {
      gx = weighted(slope(above), gx, slope(below), weight);
      gy = weighted(fall(-1), gy, fall(1), weight);
    }
    hn::StoreU(hn::Mul(gx, gx), d, xx + x);
    hn::StoreU(hn::Mul(gx, gy), d, xy + x);
    hn::StoreU(hn::Mul(gy, gy), d, yy + x);
  }
}

void GradientProducts(const float* above, const float* middle, const float* below, int width, GradientMask mask,
                      float* xx, float* xy, float* yy) {
  switch (mask) {
    case GradientMask::kCentral:
      return products<GradientMask::kCentral>(above, middle, below, width, xx, xy, yy);
    case GradientMask::kPrewitt:
      return products<GradientMask::kPrewitt>(above, middle, below, width, xx, xy, yy);
    case GradientMask::kSobel:
      return products<GradientMask::kSobel>(above, middle, below, width, xx, xy, yy);
  }
}

// The measure of tensors, from their determinants and traces.
template <CornerMeasure kMeasure>
HWY_INLINE V measured(V a, V c, V b, V parameter) {
  const D d;
  const V trace = hn::Add(a, b);
  if constexpr (kMeasure == CornerMeasure::kSmallerEigenvalue) {
    const V difference = hn::Sub(a, b), twice = hn::Add(c, c);
    const V root = hn::Sqrt(hn::MulAdd(difference, difference, hn::Mul(twice, twice)));
    return hn::Mul(hn::Set(d, 0.5f), hn::Sub(trace, root));
  }
  const V det = hn::NegMulAdd(c, c, hn::Mul(a, b));
  if constexpr (kMeasure == CornerMeasure::kHarris) return hn::NegMulAdd(hn::Mul(parameter, trace), trace, det);
  // Where nothing changes the determinant is zero, too.
  const V noble = hn::Div(det, hn::Max(trace, hn::Set(d, 1e-12f)));
  if constexpr (kMeasure == CornerMeasure::kNoble) return noble;
  const auto is_round = hn::Ge(hn::Mul(hn::Set(d, 4.0f), det), hn::Mul(parameter, hn::Mul(trace, trace)));
  return hn::IfThenElseZero(is_round, noble);
}

template <CornerMeasure kMeasure>
HWY_INLINE void responses(const float* a, const float* c, const float* b, int width, float parameter, float* out) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  const V by = hn::Set(d, parameter);
  for (int x = 0; x < width; x += n)
    hn::StoreU(measured<kMeasure>(hn::LoadU(d, a + x), hn::LoadU(d, c + x), hn::LoadU(d, b + x), by), d, out + x);
}

void CornerResponse(const float* a, const float* c, const float* b, int width, CornerMeasure measure, float parameter,
                    float* out) {
  switch (measure) {
    case CornerMeasure::kHarris:
      return responses<CornerMeasure::kHarris>(a, c, b, width, parameter, out);
    case CornerMeasure::kNoble:
      return responses<CornerMeasure::kNoble>(a, c, b, width, parameter, out);
    case CornerMeasure::kSmallerEigenvalue:
      return responses<CornerMeasure::kSmallerEigenvalue>(a, c, b, width, parameter, out);
    case CornerMeasure::kRoundNoble:
      return responses<CornerMeasure::kRoundNoble>(a, c, b, width, parameter, out);
  }
}

void SquaredDifferences(const float* a, const float* b, int width, float* out) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < width; x += n) {
    const V difference = hn::Sub(hn::LoadU(d, a + x), hn::LoadU(d, b + x));
    hn::StoreU(hn::Mul(difference, difference), d, out + x);
  }
}

void LowerTo(const float* a, int width, float* out) {
  const D d;
  const int n = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < width; x += n) hn::StoreU(hn::Min(hn::LoadU(d, a + x), hn::LoadU(d, out + x)), d, out + x);
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(GradientProducts);
HWY_EXPORT(CornerResponse);
HWY_EXPORT(SquaredDifferences);
HWY_EXPORT(LowerTo);

void gradient_products(const float* above, const float* middle, const float* below, int width, GradientMask mask,
                       float* xx, float* xy, float* yy) {
  HWY_DYNAMIC_DISPATCH(GradientProducts)(above, middle, below, width, mask, xx, xy, yy);
}

void corner_response(const float* a, const float* c, const float* b, int width, CornerMeasure measure, float parameter,
                     float* out) {
  HWY_DYNAMIC_DISPATCH(CornerResponse)(a, c, b, width, measure, parameter, out);
}

void squared_differences(const float* a, const float* b, int width, float* out) {
  HWY_DYNAMIC_DISPATCH(SquaredDifferences)(a, b, width, out);
}

void lower_to(const float* a, int width, float* out) { HWY_DYNAMIC_DISPATCH(LowerTo)(a, width, out); }

}  // namespace collinea
#endif
