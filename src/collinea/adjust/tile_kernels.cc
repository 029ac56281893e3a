// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/tile_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/adjust/tile_kernels.cc"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::bundle::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Three vectors of rows times four columns stay in registers: 12 sums, 7 loads for 12 products.
void SubtractProduct(double* HWY_RESTRICT c, const double* HWY_RESTRICT a, const double* HWY_RESTRICT b, int columns) {
  const hn::CappedTag<double, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  static_assert(kTile % 24 == 0);
  for (int row = 0; row < kTile; row += 3 * lanes) {
    for (int column = 0; column < kTile; column += 4) {
      auto s00 = hn::Zero(d), s10 = s00, s20 = s00, s01 = s00, s11 = s00, s21 = s00;
      auto s02 = s00, s12 = s00, s22 = s00, s03 = s00, s13 = s00, s23 = s00;
      const double* left = a + row;
      const double* right = b + column;
      for (int k = 0; k < columns; ++k, left += kTile, right += kTile) {
        const auto a0 = hn::LoadU(d, left), a1 = hn::LoadU(d, left + lanes), a2 = hn::LoadU(d, left + 2 * lanes);
        const auto b0 = hn::Set(d, right[0]), b1 = hn::Set(d, right[1]);
        s00 = hn::MulAdd(a0, b0, s00), s10 = hn::MulAdd(a1, b0, s10), s20 = hn::MulAdd(a2, b0, s20);
        s01 = hn::MulAdd(a0, b1, s01), s11 = hn::MulAdd(a1, b1, s11), s21 = hn::MulAdd(a2, b1, s21);
        const auto b2 = hn::Set(d, right[2]), b3 = hn::Set(d, right[3]);
        s02 = hn::MulAdd(a0, b2, s02), s12 = hn::MulAdd(a1, b2, s12), s22 = hn::MulAdd(a2, b2, s22);
        s03 = hn::MulAdd(a0, b3, s03), s13 = hn::MulAdd(a1, b3, s13), s23 = hn::MulAdd(a2, b3, s23);
      }
      const auto take = [&](int j, auto s0, auto s1, auto s2) {
        double* out = c + (column + j) * kTile + row;
        hn::StoreU(hn::Sub(hn::LoadU(d, out), s0), d, out);
        hn::StoreU(hn::Sub(hn::LoadU(d, out + lanes), s1), d, out + lanes);
        hn::StoreU(hn::Sub(hn::LoadU(d, out + 2 * lanes), s2), d, out + 2 * lanes);
      };
      take(0, s00, s10, s20);
      take(1, s01, s11, s21);
      take(2, s02, s12, s22);
      take(3, s03, s13, s23);
    }
  }
}

// Six rows are a vector of four and one of two (or three of two).
void SubtractOuter(double* const* blocks, const double* HWY_RESTRICT z_row, const PoseRay* columns, int count) {
  const hn::CappedTag<double, 4> d4;
  const hn::CappedTag<double, 2> d2;
  if (hn::Lanes(d4) != 4 || hn::Lanes(d2) != 2) {
    for (int n = 0; n < count; ++n)
      for (int c = 0; c < 6; ++c)
        for (int r = 0; r < 6; ++r)
          for (int k = 0; k < 3; ++k) blocks[n][c * kTile + r] -= z_row[6 * k + r] * columns[n].z[6 * k + c];
    return;
  }
  const auto a0 = hn::LoadU(d4, z_row), a1 = hn::LoadU(d4, z_row + 6), a2 = hn::LoadU(d4, z_row + 12);
  const auto e0 = hn::LoadU(d2, z_row + 4), e1 = hn::LoadU(d2, z_row + 10), e2 = hn::LoadU(d2, z_row + 16);
  for (int n = 0; n < count; ++n) {
    const double* z = columns[n].z;
    double* out = blocks[n];
    for (int c = 0; c < 6; ++c, out += kTile) {
      auto upper = hn::NegMulAdd(a0, hn::Set(d4, z[c]), hn::LoadU(d4, out));
      auto lower = hn::NegMulAdd(e0, hn::Set(d2, z[c]), hn::LoadU(d2, out + 4));
      upper = hn::NegMulAdd(a1, hn::Set(d4, z[6 + c]), upper);
      lower = hn::NegMulAdd(e1, hn::Set(d2, z[6 + c]), lower);
      hn::StoreU(hn::NegMulAdd(a2, hn::Set(d4, z[12 + c]), upper), d4, out);
      hn::StoreU(hn::NegMulAdd(e2, hn::Set(d2, z[12 + c]), lower), d2, out + 4);
    }
  }
}

}  // namespace collinea::bundle::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::bundle {

HWY_EXPORT(SubtractProduct);
HWY_EXPORT(SubtractOuter);

void subtract_product(double* c, const double* a, const double* b, int columns) {
  HWY_DYNAMIC_DISPATCH(SubtractProduct)(c, a, b, columns);
}

void subtract_outer(double* const* blocks, const double* z_row, const PoseRay* columns, int count) {
  HWY_DYNAMIC_DISPATCH(SubtractOuter)(blocks, z_row, columns, count);
}

}  // namespace collinea::bundle
#endif
