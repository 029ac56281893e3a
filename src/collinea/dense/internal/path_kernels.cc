// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/path_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/internal/path_kernels.cc"
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
      const auto neighbours = hn::Min(hn::LoadU(d, from.costs + k - 1), hn::LoadU(d, from.costs + k + 1));
      auto best = hn::Min(hn::LoadU(d, from.costs + k), hn::SaturatedAdd(neighbours, step));
      best = hn::Sub(hn::Min(best, jump), smallest);
      const auto leave = hn::Add(best, hn::PromoteTo(d, hn::LoadU(d8, cost + k)));
      least = hn::Min(least, leave);
      hn::StoreU(leave, d, leaving[p] + k);
      hn::StoreU(hn::Add(hn::LoadU(d, sums + k), leave), d, sums + k);
    }
    smallest_leaving[p] = hn::GetLane(hn::MinOfLanes(d, least));
  }
}

int FirstLeast(const std::uint16_t* values, int from, int to) {
  const hn::CappedTag<std::uint16_t, 16> d;
  const int lanes = int(hn::Lanes(d));
  const auto most = hn::Set(d, std::uint16_t(0xFFFF)), count = hn::Set(d, std::uint16_t(to - from));
  const auto counts = [&](int i) { return hn::Lt(hn::Iota(d, std::uint16_t(i - from)), count); };  // before from: huge
  auto least = most;
  for (int i = 0; i < to; i += lanes) least = hn::Min(least, hn::IfThenElse(counts(i), hn::LoadU(d, values + i), most));
  const auto wanted = hn::Set(d, hn::GetLane(hn::MinOfLanes(d, least)));
  for (int i = 0;; i += lanes) {
    const auto equal = hn::And(counts(i), hn::Eq(hn::LoadU(d, values + i), wanted));
    if (const auto at = hn::FindFirstTrue(d, equal); at >= 0) return i + int(at);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {

HWY_EXPORT(StepPaths);
HWY_EXPORT(FirstLeast);

void step_paths(const std::uint8_t* cost, int stride, const Arriving* arriving, int count, std::uint16_t small,
                std::uint16_t* const* leaving, std::uint16_t* smallest_leaving, std::uint16_t* sums) {
  HWY_DYNAMIC_DISPATCH(StepPaths)(cost, stride, arriving, count, small, leaving, smallest_leaving, sums);
}

int first_least(const std::uint16_t* values, int from, int to) {
  return HWY_DYNAMIC_DISPATCH(FirstLeast)(values, from, to);
}

}  // namespace collinea::dense
#endif  // HWY_ONCE
