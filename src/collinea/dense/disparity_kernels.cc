// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/disparity_kernels.h"

#include <algorithm>

#define HWY_WANT_AVX3_DL  // counts bits in one instruction
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/disparity_kernels.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void CensusRow(const std::uint8_t* const* rows, int width, std::uint32_t* HWY_RESTRICT words) {
  constexpr int kSide = 2 * kCensusReach + 1, kNeighbours = kSide * kSide - 1;
  const hn::CappedTag<std::uint8_t, 64> d;
  const hn::RebindToSigned<decltype(d)> i;
  const auto sign = hn::Set(d, 0x80);
  for (int x = 0; x < width; x += int(hn::Lanes(d))) {
    const auto middle = hn::LoadU(d, rows[kCensusReach] + x);
    const auto own = hn::BitCast(i, hn::Xor(middle, sign));
    auto least = middle;
    // eight of the neighbours, counted row by row from `first` on, fill a byte of every word
    const auto byte_of = [&](int first) {
      auto bits = hn::Zero(d);
      for (int n = first; n < first + 8; ++n) {
        const int at = n < kNeighbours / 2 ? n : n + 1;  // without the middle
        const auto other = hn::LoadU(d, rows[at / kSide] + x + at % kSide - kCensusReach);
        least = hn::Min(least, other);
        const auto darker = hn::VecFromMask(i, hn::Lt(hn::BitCast(i, hn::Xor(other, sign)), own));
        bits = hn::Sub(hn::Add(bits, bits), hn::BitCast(d, darker));
      }
      return bits;
    };
    const auto first = byte_of(0), second = byte_of(8), third = byte_of(16);
    const auto fourth = hn::IfThenElseZero(hn::Eq(least, hn::Zero(d)), sign);
    hn::StoreInterleaved4(first, second, third, fourth, d, reinterpret_cast<std::uint8_t*>(words + x));
  }
}

void CensusCosts(const std::uint32_t* left, const std::uint32_t* right, int width, int labels, int stride, int chance,
                 std::uint8_t* HWY_RESTRICT costs) {
  const hn::CappedTag<std::uint32_t, 16> d;
  const hn::RebindToSigned<decltype(d)> i;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const auto unknown = hn::Set(d, std::uint32_t(chance));
  for (int x = 0; x < width; ++x, costs += stride) {
    const auto own = hn::Set(d, left[x]);
    const std::uint32_t* others = right + width - 1 - x;
    for (int k = 0; k < stride; k += int(hn::Lanes(d))) {
      const auto other = hn::LoadU(d, others + k);
      const auto missing = hn::RebindMask(d, hn::Lt(hn::BitCast(i, hn::Or(own, other)), hn::Zero(i)));
      const auto bits = hn::PopulationCount(hn::Xor(own, other));
      const auto cost = hn::IfThenElse(missing, unknown, hn::Add(bits, bits));
      hn::StoreU(hn::DemoteTo(d8, hn::BitCast(i, cost)), d8, costs + k);
    }
    std::fill(costs + labels, costs + stride, std::uint8_t(255));
  }
}

void JumpRow(const std::uint8_t* HWY_RESTRICT here, const std::uint8_t* HWY_RESTRICT before, int sense, int width,
             std::uint8_t* HWY_RESTRICT jumps) {
  const hn::CappedTag<float, 16> f;
  const hn::RebindToSigned<decltype(f)> i;
  const hn::Rebind<std::uint8_t, decltype(f)> d8;
  for (int x = 0; x < width; x += int(hn::Lanes(f))) {
    const auto own = hn::PromoteTo(i, hn::LoadU(d8, here + x));
    const auto jump = [&](const std::uint8_t* from) {
      const auto apart = hn::Abs(hn::Sub(own, hn::PromoteTo(i, hn::LoadU(d8, from + x))));
      const auto part = hn::ConvertTo(f, hn::Add(apart, hn::Set(i, kGreyOfJump)));
      const auto toll = hn::ConvertTo(i, hn::Div(hn::Set(f, float(kJumpScale)), part));
      return hn::DemoteTo(d8, hn::Max(toll, hn::Set(i, kLeastJump)));
    };
    hn::StoreInterleaved4(jump(here - sense), jump(before - sense), jump(before), jump(before + sense), d8,
                          jumps + 4 * x);
  }
}

#if HWY_TARGET == HWY_SCALAR  // processors without vectors have no halves of them either

void SweepRow(RowOfSweep& row, int from, int to) {
  const int stride = row.stride;
  for (int i = from; i < to; ++i) {
    const int x = row.sense > 0 ? i : row.width - 1 - i;
    const std::uint8_t* costs = row.costs + std::size_t(x) * std::size_t(stride);
    std::uint8_t* tolls = row.tolls + std::size_t(x) * std::size_t(stride);
    for (int k = 0; k < stride; ++k) row.sums[k] = std::uint16_t(row.sense > 0 ? 0 : tolls[k] + 8 * costs[k]);
    const auto path = [&](const std::uint8_t* arriving, int smallest, int large, std::uint8_t* leaving) {
      int least = 255;
      for (int k = 0; k < stride; ++k) {
        const int near =
            std::min<int>(arriving[k], std::min(std::min(arriving[k - 1], arriving[k + 1]) + row.small[x], 255));
        const int toll = std::min(near, std::min(large + smallest, 255)) - smallest;
        leaving[k] = std::uint8_t(std::min(toll + costs[k], 255));
        least = std::min<int>(least, leaving[k]);
        row.sums[k] = std::uint16_t(row.sums[k] + toll);
      }
      return std::uint8_t(least);
    };
    const int other_side = stride + 2 * kPathGuard;
    row.side_smallest = path(row.side + (i & 1 ? other_side : 0) + kPathGuard, row.side_smallest, row.large[x * 4],
                             row.side + (i & 1 ? 0 : other_side) + kPathGuard);
    for (int p = 0; p < 3; ++p) {
      const int column = x + (p - 1) * row.sense;
      row.now.smallest[(x + 1) * 4 + p] =
          path(row.before.costs + PathRow::offset(column, p, stride), row.before.smallest[(column + 1) * 4 + p],
               row.large[x * 4 + p + 1], row.now.costs + PathRow::offset(x, p, stride));
    }
    if (row.sense > 0) {
      std::copy_n(row.sums, stride, tolls);
      continue;
    }
    const int k = int(std::min_element(row.sums, row.sums + stride) - row.sums);
    for (int j = 0; j < stride; ++j) {
      std::uint16_t& known = row.right_sum[row.width - 1 - x + j];
      if (row.sums[j] < known) known = row.sums[j], row.right_label[row.width - 1 - x + j] = std::uint16_t(j);
    }
    row.best[x] = {std::uint16_t(k), k > 0 ? row.sums[k - 1] : std::uint16_t(0xFFFF), row.sums[k],
                   k + 1 < row.labels ? row.sums[k + 1] : std::uint16_t(0xFFFF)};
  }
}

#else

template <class D, class V>
HWY_INLINE std::uint8_t SmallestLane(D d, V v) {
  if constexpr (hn::MaxLanes(D()) > 16) {
    const hn::Half<D> half;
    return SmallestLane(half, hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  } else {
    const hn::Repartition<std::uint16_t, D> wide;
    const auto pairs = hn::BitCast(wide, v);
    const auto least = hn::Min(hn::And(pairs, hn::Set(wide, 0xFF)), hn::ShiftRight<8>(pairs));
    return std::uint8_t(hn::GetLane(hn::MinOfLanes(wide, least)));
  }
}

template <class D>
struct Arrival {
  const std::uint8_t* costs;
  hn::Vec<D> smallest, jump;

  Arrival(D d, const std::uint8_t* arriving, std::uint8_t least, std::uint8_t large)
      : costs(arriving), smallest(hn::Set(d, least)), jump(hn::SaturatedAdd(hn::Set(d, large), smallest)) {}

  // what the path has to pay beyond its least cost to get here
  HWY_INLINE hn::Vec<D> toll(D d, int k, hn::Vec<D> small) const {
    const auto beside = hn::Min(hn::LoadU(d, costs + k - 1), hn::LoadU(d, costs + k + 1));
    const auto near = hn::Min(hn::LoadU(d, costs + k), hn::SaturatedAdd(beside, small));
    return hn::Sub(hn::Min(near, jump), smallest);
  }
};

// Where the first of `count` sums is that equals `least`, which is one of them.
template <class D16>
HWY_INLINE int FirstEqual(D16 d, const std::uint16_t* sums, std::uint16_t least) {
  const auto wanted = hn::Set(d, least);
  for (int k = 0;; k += int(hn::Lanes(d)))
    if (const auto at = hn::FindFirstTrue(d, hn::Eq(hn::LoadU(d, sums + k), wanted)); at >= 0) return k + int(at);
}

template <class D16>
HWY_INLINE void SeeFromTheRight(D16 d, hn::Vec<D16> sum, int k, std::uint16_t* HWY_RESTRICT sums,
                                std::uint16_t* HWY_RESTRICT labels) {
  const auto known = hn::LoadU(d, sums + k);
  const auto less = hn::Lt(sum, known);
  const auto own = hn::Add(hn::Iota(d, 0), hn::Set(d, std::uint16_t(k)));
  hn::StoreU(hn::Min(sum, known), d, sums + k);
  hn::StoreU(hn::IfThenElse(less, own, hn::LoadU(d, labels + k)), d, labels + k);
}

template <int kLanes, bool kUp>
HWY_INLINE void SweepColumns(RowOfSweep& row, int from, int to) {
  const hn::CappedTag<std::uint8_t, kLanes> d;
  using D = decltype(d);
  const hn::Half<D> half;
  const hn::Repartition<std::uint16_t, D> d16;
  const int lanes = int(hn::Lanes(d)), lanes16 = lanes / 2, stride = row.stride;
  const int behind = -row.sense, ahead = row.sense;
  for (int i = from; i < to; ++i) {
    const int x = row.sense > 0 ? i : row.width - 1 - i;
    const std::uint8_t* large = row.large + x * 4;
    const std::uint8_t* from_side = row.side + (i & 1 ? stride + 2 * kPathGuard : 0) + kPathGuard;
    std::uint8_t* to_side = row.side + (i & 1 ? 0 : stride + 2 * kPathGuard) + kPathGuard;
    const auto arrival = [&](int column, int p) {
      return Arrival<D>(d, row.before.costs + PathRow::offset(column, p, stride),
                        row.before.smallest[(column + 1) * 4 + p], large[p + 1]);
    };
    const Arrival<D> side(d, from_side, row.side_smallest, large[0]);
    const Arrival<D> oblique = arrival(x + behind, 0), straight = arrival(x, 1), other = arrival(x + ahead, 2);
    std::uint8_t* to_oblique = row.now.costs + PathRow::offset(x, 0, stride);
    std::uint8_t* to_straight = row.now.costs + PathRow::offset(x, 1, stride);
    std::uint8_t* to_other = row.now.costs + PathRow::offset(x, 2, stride);
    const std::uint8_t* costs = row.costs + std::size_t(x) * std::size_t(stride);
    std::uint8_t* tolls = row.tolls + std::size_t(x) * std::size_t(stride);
    std::uint16_t* right_sum = kUp ? row.right_sum + row.width - 1 - x : nullptr;
    std::uint16_t* right_label = kUp ? row.right_label + row.width - 1 - x : nullptr;
    const auto small = hn::Set(d, row.small[x]);
    auto least0 = hn::Set(d, 255), least1 = least0, least2 = least0, least3 = least0;
    auto least_sum = hn::Set(d16, 0xFFFF);
    for (int k = 0; k < stride; k += lanes) {
      const auto cost = hn::LoadU(d, costs + k);
      const auto t0 = side.toll(d, k, small), t1 = oblique.toll(d, k, small);
      const auto t2 = straight.toll(d, k, small), t3 = other.toll(d, k, small);
      const auto v0 = hn::SaturatedAdd(t0, cost), v1 = hn::SaturatedAdd(t1, cost);
      const auto v2 = hn::SaturatedAdd(t2, cost), v3 = hn::SaturatedAdd(t3, cost);
      least0 = hn::Min(least0, v0), least1 = hn::Min(least1, v1);
      least2 = hn::Min(least2, v2), least3 = hn::Min(least3, v3);
      hn::StoreU(v0, d, to_side + k);
      hn::StoreU(v1, d, to_oblique + k);
      hn::StoreU(v2, d, to_straight + k);
      hn::StoreU(v3, d, to_other + k);
      const auto sum_of_tolls = hn::Add(hn::Add(t0, t1), hn::Add(t2, t3));
      if constexpr (kUp) {
        const auto below = hn::LoadU(d, tolls + k);
        const auto eightfold = [&](auto part) {
          const auto both = hn::Add(hn::PromoteTo(d16, part(sum_of_tolls)), hn::PromoteTo(d16, part(below)));
          return hn::Add(both, hn::ShiftLeft<3>(hn::PromoteTo(d16, part(cost))));
        };
        const auto low = eightfold([&](auto v) { return hn::LowerHalf(half, v); });
        const auto high = eightfold([&](auto v) { return hn::UpperHalf(half, v); });
        least_sum = hn::Min(least_sum, hn::Min(low, high));
        SeeFromTheRight(d16, low, k, right_sum, right_label);
        SeeFromTheRight(d16, high, k + lanes16, right_sum, right_label);
        hn::StoreU(low, d16, row.sums + k);
        hn::StoreU(high, d16, row.sums + k + lanes16);
      } else {
        hn::StoreU(sum_of_tolls, d, tolls + k);
      }
    }
    row.side_smallest = SmallestLane(d, least0);
    std::uint8_t* smallest = row.now.smallest + (x + 1) * 4;
    smallest[0] = SmallestLane(d, least1);
    smallest[1] = SmallestLane(d, least2);
    smallest[2] = SmallestLane(d, least3);
    if constexpr (kUp) {
      const int k = FirstEqual(d16, row.sums, hn::GetLane(hn::MinOfLanes(d16, least_sum)));
      row.best[x] = {std::uint16_t(k), k > 0 ? row.sums[k - 1] : std::uint16_t(0xFFFF), row.sums[k],
                     k + 1 < row.labels ? row.sums[k + 1] : std::uint16_t(0xFFFF)};
    }
  }
}

void SweepRow(RowOfSweep& row, int from, int to) {
  const bool wide = row.stride % 64 == 0, up = row.sense < 0;
  if (wide && up) return SweepColumns<64, true>(row, from, to);
  if (wide) return SweepColumns<64, false>(row, from, to);
  if (up) return SweepColumns<32, true>(row, from, to);
  SweepColumns<32, false>(row, from, to);
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {

HWY_EXPORT(CensusRow);
HWY_EXPORT(CensusCosts);
HWY_EXPORT(JumpRow);
HWY_EXPORT(SweepRow);

void census_row(const std::uint8_t* const* rows, int width, std::uint32_t* words) {
  HWY_DYNAMIC_DISPATCH(CensusRow)(rows, width, words);
}

void census_costs(const std::uint32_t* left, const std::uint32_t* right, int width, int labels, int stride, int chance,
                  std::uint8_t* costs) {
  HWY_DYNAMIC_DISPATCH(CensusCosts)(left, right, width, labels, stride, chance, costs);
}

void jump_row(const std::uint8_t* here, const std::uint8_t* before, int sense, int width, std::uint8_t* jumps) {
  HWY_DYNAMIC_DISPATCH(JumpRow)(here, before, sense, width, jumps);
}

void sweep_columns(RowOfSweep& row, int from, int to) { HWY_DYNAMIC_DISPATCH(SweepRow)(row, from, to); }

}  // namespace collinea::dense
#endif  // HWY_ONCE
