// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/local_kernels.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/internal/local_kernels.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::Rebind<std::int32_t, F>;
using U8 = hn::Rebind<std::uint8_t, F>;
constexpr F f;
constexpr I i32;
constexpr U8 u8;

template <PixelTerm kTerm>
HWY_INLINE hn::Vec<I> TermsAt(const PixelRows& rows, int x) {
  if constexpr (kTerm == PixelTerm::kBits) {
    auto count = hn::Zero(u8);
    for (std::size_t i = 0; i < rows.planes; ++i)
      count = hn::Add(count,
                      hn::PopulationCount(hn::Xor(hn::LoadU(u8, rows.left[i] + x), hn::LoadU(u8, rows.right[i] + x))));
    return hn::PromoteTo(i32, count);
  } else {
    const auto left = hn::PromoteTo(i32, hn::LoadU(u8, rows.left[0] + x));
    const auto right = hn::PromoteTo(i32, hn::LoadU(u8, rows.right[0] + x));
    if constexpr (kTerm == PixelTerm::kProduct) return hn::Mul(left, right);
    const auto difference = hn::Sub(left, right);
    if constexpr (kTerm == PixelTerm::kSquare) return hn::Mul(difference, difference);
    return hn::Abs(difference);
  }
}

template <PixelTerm kTerm>
HWY_INLINE void Slide(const PixelRows& entering, const PixelRows* leaving, int width, std::int32_t* sums) {
  const PixelRows in = entering, out = leaving ? *leaving : entering;
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    auto sum = hn::Add(hn::LoadU(i32, sums + x), TermsAt<kTerm>(in, x));
    if (leaving) sum = hn::Sub(sum, TermsAt<kTerm>(out, x));
    hn::StoreU(sum, i32, sums + x);
  }
}

void SlideColumns(PixelTerm term, const PixelRows& entering, const PixelRows* leaving, int width, std::int32_t* sums) {
  switch (term) {
    case PixelTerm::kProduct:
      return Slide<PixelTerm::kProduct>(entering, leaving, width, sums);
    case PixelTerm::kSquare:
      return Slide<PixelTerm::kSquare>(entering, leaving, width, sums);
    case PixelTerm::kDifference:
      return Slide<PixelTerm::kDifference>(entering, leaving, width, sums);
    case PixelTerm::kBits:
      return Slide<PixelTerm::kBits>(entering, leaving, width, sums);
  }
}

void CostsOfSums(const std::int32_t* sums, const float* left_penalty, const float* right_penalty, int width,
                 float* costs) {
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    const auto penalty = hn::Add(hn::LoadU(f, left_penalty + x), hn::LoadU(f, right_penalty + x));
    hn::StoreU(hn::Add(hn::ConvertTo(f, hn::LoadU(i32, sums + x)), penalty), f, costs + x);
  }
}

void CostsOfProducts(const std::int32_t* products, const WindowMoments& left, const WindowMoments& right, float n,
                     const float* left_penalty, const float* right_penalty, int width, float* costs) {
  // The covariance is a small difference of large whole numbers.
  const hn::CappedTag<double, 8> d;
  const hn::Rebind<std::int32_t, decltype(d)> of_sums;
  const hn::Rebind<float, decltype(d)> of_costs;
  const auto part = hn::Set(d, 1.0 / double(n));
  const auto sum_at = [&](const std::int32_t* sums) { return hn::PromoteTo(d, hn::LoadU(of_sums, sums)); };
  const auto one = hn::Set(of_costs, 1.0f);
  for (int x = 0; x < width; x += int(hn::Lanes(d))) {
    const auto of_means = hn::Mul(hn::Mul(sum_at(left.sum + x), sum_at(right.sum + x)), part);
    const auto covariance = hn::DemoteTo(of_costs, hn::Sub(sum_at(products + x), of_means));
    const auto scale = hn::Mul(hn::LoadU(of_costs, left.scale + x), hn::LoadU(of_costs, right.scale + x));
    const auto penalty = hn::Add(hn::LoadU(of_costs, left_penalty + x), hn::LoadU(of_costs, right_penalty + x));
    const auto cost = hn::Max(hn::Sub(one, hn::Mul(covariance, scale)), hn::Zero(of_costs));
    hn::StoreU(hn::Add(cost, penalty), of_costs, costs + x);
  }
}

void TakeLabel(const float* costs, int label, int width, const BestLabels& left, const BestFromRight& right) {
  const auto here = hn::Set(f, float(label)), before_here = hn::Set(f, float(label - 1));
  const auto nothing = hn::Set(f, std::numeric_limits<float>::infinity());
  const BestLabels of = left;
  const BestFromRight there = right;
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    const auto cost = hn::LoadU(f, costs + x), best = hn::LoadU(f, of.best + x),
               label_then = hn::LoadU(f, of.label + x), last = hn::LoadU(f, of.last + x),
               last_but_1 = hn::LoadU(f, of.last_but_1 + x);
    const auto earlier = hn::Min(hn::LoadU(f, of.earlier + x), last_but_1);
    const auto is_better = hn::Lt(cost, best), is_next = hn::Eq(label_then, before_here);
    const auto second = hn::LoadU(f, of.second + x), after = hn::LoadU(f, of.after + x);
    hn::StoreU(hn::IfThenElse(is_better, earlier, hn::IfThenElse(is_next, second, hn::Min(second, cost))), f,
               of.second + x);
    hn::StoreU(hn::IfThenElse(is_better, nothing, hn::IfThenElse(is_next, cost, after)), f, of.after + x);
    hn::StoreU(hn::IfThenElse(is_better, last, hn::LoadU(f, of.before + x)), f, of.before + x);
    hn::StoreU(hn::Min(best, cost), f, of.best + x);
    hn::StoreU(hn::IfThenElse(is_better, here, label_then), f, of.label + x);
    hn::StoreU(earlier, f, of.earlier + x);
    hn::StoreU(last, f, of.last_but_1 + x);
    hn::StoreU(cost, f, of.last + x);
    const auto best_there = hn::LoadU(f, there.best + x), label_there = hn::LoadU(f, there.label + x);
    hn::StoreU(hn::IfThenElse(hn::Lt(cost, best_there), here, label_there), f, there.label + x);
    hn::StoreU(hn::Min(best_there, cost), f, there.best + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {

HWY_EXPORT(SlideColumns);
HWY_EXPORT(CostsOfSums);
HWY_EXPORT(CostsOfProducts);
HWY_EXPORT(TakeLabel);

void slide_columns(PixelTerm term, const PixelRows& entering, const PixelRows* leaving, int width, std::int32_t* sums) {
  HWY_DYNAMIC_DISPATCH(SlideColumns)(term, entering, leaving, width, sums);
}

void costs_of_sums(const std::int32_t* sums, const float* left_penalty, const float* right_penalty, int width,
                   float* costs) {
  HWY_DYNAMIC_DISPATCH(CostsOfSums)(sums, left_penalty, right_penalty, width, costs);
}

void costs_of_products(const std::int32_t* products, const WindowMoments& left, const WindowMoments& right, float n,
                       const float* left_penalty, const float* right_penalty, int width, float* costs) {
  HWY_DYNAMIC_DISPATCH(CostsOfProducts)(products, left, right, n, left_penalty, right_penalty, width, costs);
}

void take_label(const float* costs, int label, int width, const BestLabels& left, const BestFromRight& right) {
  HWY_DYNAMIC_DISPATCH(TakeLabel)(costs, label, width, left, right);
}

}  // namespace collinea::dense
#endif  // HWY_ONCE
