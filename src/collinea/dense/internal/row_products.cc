// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/row_products.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/internal/row_products.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void RowProducts(const std::int16_t* pattern, int pattern_width, int side, const std::uint8_t* pixels, int stride,
                 int columns, std::int32_t* products) {
  const hn::CappedTag<std::int16_t, kPatternUnit> i16;
  const hn::Rebind<std::uint8_t, decltype(i16)> u8;
  const hn::RepartitionToWide<decltype(i16)> i32;
  const int lanes = int(hn::Lanes(i16));
  for (int x = 0; x < columns; ++x) {
    auto even = hn::Zero(i32), odd = hn::Zero(i32);
    for (int v = 0; v < side; ++v) {
      const std::uint8_t* row = pixels + v * stride + x;
      const std::int16_t* of = pattern + v * pattern_width;
      for (int u = 0; u < pattern_width; u += lanes)
        even = hn::ReorderWidenMulAccumulate(i32, hn::LoadU(i16, of + u), hn::PromoteTo(i16, hn::LoadU(u8, row + u)),
                                             even, odd);
    }
    products[x] = hn::GetLane(hn::SumOfLanes(i32, hn::Add(even, odd)));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {

HWY_EXPORT(RowProducts);

void row_products(const std::int16_t* pattern, int pattern_width, int side, const std::uint8_t* pixels, int stride,
                  int columns, std::int32_t* products) {
  HWY_DYNAMIC_DISPATCH(RowProducts)(pattern, pattern_width, side, pixels, stride, columns, products);
}

}  // namespace collinea::dense
#endif  // HWY_ONCE
