// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/path_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/path_kernels.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void StepPaths(const std::uint8_t* HWY_RESTRICT cost, int stride, const Arriving* arriving, int count,
               std::uint16_t small, std::uint16_t* const* leaving, std::uint16_t* smallest_leaving,
               std::uint16_t* HWY_RESTRICT sums) {
  const hn::CappedTag<std::uint16_t, 16> d;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const int lanes = int(hn::Lanes(d));
  const auto step = hn::Set(d, small);
  for (int p = 0; p < count; ++p) {
    const Arriving& from = arriving[p];
    const auto smallest = hn::Set(d, from.smallest);
    const auto jump = hn::Set(d, std::uint16_t(from.smallest + from.large));
    auto least = hn::Set(d, std::uint16_t(0xFFFF));
    for (int k = 0; k < stride; k += lanes) {
      const auto beside = hn::Min(hn::LoadU(d, from.costs + k - 1), hn::LoadU(d, from.costs + k + 1));
      auto best = hn::Min(hn::LoadU(d, from.costs + k), hn::SaturatedAdd(beside, step));
      best = hn::Sub(hn::Min(best, jump), smallest);
      const auto leave = hn::Add(best, hn::PromoteTo(d, hn::LoadU(d8, cost + k)));
      least = hn::Min(least, leave);
      hn::StoreU(leave, d, leaving[p] + k);
      hn::StoreU(hn::Add(hn::LoadU(d, sums + k), leave), d, sums + k);
    }
    smallest_leaving[p] = hn::GetLane(hn::MinOfLanes(d, least));
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {

HWY_EXPORT(StepPaths);

void step_paths(const std::uint8_t* cost, int stride, const Arriving* arriving, int count, std::uint16_t small,
                std::uint16_t* const* leaving, std::uint16_t* smallest_leaving, std::uint16_t* sums) {
  HWY_DYNAMIC_DISPATCH(StepPaths)(cost, stride, arriving, count, small, leaving, smallest_leaving, sums);
}

}  // namespace collinea::dense
#endif  // HWY_ONCE
