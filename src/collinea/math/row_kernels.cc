// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/row_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/math/row_kernels.cc"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void AddMultiple(double* x, const double* y, double factor, int count) {
  const hn::ScalableTag<double> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto f = hn::Set(d, factor);
  int k = 0;
  for (; k + lanes <= count; k += lanes)
    hn::StoreU(hn::Add(hn::LoadU(d, x + k), hn::Mul(f, hn::LoadU(d, y + k))), d, x + k);
  for (; k < count; ++k) x[k] += factor * y[k];
}

void SubtractMultiples(double* x, const double* const* y, const double* z, int count) {
  const hn::ScalableTag<double> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const double *y0 = y[0], *y1 = y[1], *y2 = y[2];
  const auto z0 = hn::Set(d, z[0]), z1 = hn::Set(d, z[1]), z2 = hn::Set(d, z[2]);
  int k = 0;
  for (; k + lanes <= count; k += lanes) {
    const auto two = hn::Add(hn::Mul(z0, hn::LoadU(d, y0 + k)), hn::Mul(z1, hn::LoadU(d, y1 + k)));
    const auto sum = hn::Add(two, hn::Mul(z2, hn::LoadU(d, y2 + k)));
    hn::StoreU(hn::Sub(hn::LoadU(d, x + k), sum), d, x + k);
  }
  for (; k < count; ++k) x[k] -= z[0] * y0[k] + z[1] * y1[k] + z[2] * y2[k];
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(AddMultiple);
HWY_EXPORT(SubtractMultiples);

void add_multiple(double* x, const double* y, double factor, int count) {
  HWY_DYNAMIC_DISPATCH(AddMultiple)(x, y, factor, count);
}

void subtract_multiples(double* x, const double* const* y, const double* z, int count) {
  HWY_DYNAMIC_DISPATCH(SubtractMultiples)(x, y, z, count);
}

}  // namespace collinea
#endif
