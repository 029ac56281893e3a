// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/disparity_kernels.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#define HWY_WANT_AVX3_DL  // counts bits in one instruction
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/internal/disparity_kernels.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void CensusRow(const std::uint8_t* const* rows, int width, bool mirrored, const CensusRows<std::uint8_t>& census) {
  constexpr int kSide = 2 * kCensusReach + 1, kNeighbours = kSide * kSide - 1;
  const hn::CappedTag<std::uint8_t, 64> d;
  const hn::RebindToSigned<decltype(d)> i;
  const auto sign = hn::Set(d, 0x80);
  std::array<const std::uint8_t*, kNeighbours> around;  // row by row, without the middle
  for (int n = 0; n < kNeighbours; ++n) {
    const int at = n < kNeighbours / 2 ? n : n + 1, column = at % kSide - kCensusReach;
    around[std::size_t(n)] = rows[at / kSide] + (mirrored ? -column : column);
  }
  for (int x = 0; x < width; x += int(hn::Lanes(d))) {
    const auto middle = hn::LoadU(d, rows[kCensusReach] + x);
    const auto own = hn::BitCast(i, hn::Xor(middle, sign));
    auto least = middle;
    // eight of the neighbours from `first` on fill a byte
    const auto byte_of = [&](std::size_t first) {
      auto bits = hn::Zero(d);
      for (std::size_t n = first; n < first + 8; ++n) {
        const auto other = hn::LoadU(d, around[n] + x);
        least = hn::Min(least, other);
        const auto darker = hn::VecFromMask(i, hn::Lt(hn::BitCast(i, hn::Xor(other, sign)), own));
        bits = hn::Sub(hn::Add(bits, bits), hn::BitCast(d, darker));
      }
      return bits;
    };
    for (std::size_t byte = 0; byte < 3; ++byte) hn::StoreU(byte_of(8 * byte), d, census[byte] + x);
    hn::StoreU(hn::VecFromMask(d, hn::Eq(least, hn::Zero(d))), d, census[3] + x);
  }
}

template <int kLanes>
HWY_INLINE void CostsOfRow(const CensusRows<const std::uint8_t>& left, const CensusRows<const std::uint8_t>& right,
                           int width, int labels, int stride, int chance, std::uint8_t* HWY_RESTRICT costs) {
  const hn::CappedTag<std::uint8_t, kLanes> d;
  const auto unknown = hn::Set(d, std::uint8_t(chance));
  // apart from the arrays: writing bytes might change those for all that the compiler knows
  const std::uint8_t *const left0 = left[0], *const left1 = left[1], *const left2 = left[2], *const left3 = left[3];
  const std::uint8_t *const right0 = right[0], *const right1 = right[1], *const right2 = right[2],
                            *const right3 = right[3];
  for (int x = 0; x < width; ++x, costs += stride) {
    if (left3[x]) {
      std::fill(costs, costs + labels, std::uint8_t(chance));
    } else {
      const auto first = hn::Set(d, left0[x]), second = hn::Set(d, left1[x]), third = hn::Set(d, left2[x]);
      const int others = width - 1 - x;
      for (int k = 0; k < stride; k += int(hn::Lanes(d))) {
        const auto differing = [&](auto own, const std::uint8_t* other) {
          return hn::PopulationCount(hn::Xor(own, hn::LoadU(d, other + others + k)));
        };
        const auto bits =
            hn::Add(hn::Add(differing(first, right0), differing(second, right1)), differing(third, right2));
        const auto missing = hn::MaskFromVec(hn::LoadU(d, right3 + others + k));
        hn::StoreU(hn::IfThenElse(missing, unknown, hn::Add(bits, bits)), d, costs + k);
      }
    }
    if (labels < stride) std::fill(costs + labels, costs + stride, std::uint8_t(255));
  }
}

void CensusCosts(const CensusRows<const std::uint8_t>& left, const CensusRows<const std::uint8_t>& right, int width,
                 int labels, int stride, int chance, std::uint8_t* costs) {
  if (stride % 64 == 0)
    CostsOfRow<64>(left, right, width, labels, stride, chance, costs);
  else
    CostsOfRow<32>(left, right, width, labels, stride, chance, costs);
}

// From a difference of grey values on, the least toll is all that is paid: what is less fits into two tables.
constexpr int kJumpTables = 32;
static_assert(kJumpScale / (kGreyOfJump + kJumpTables - 1) <= kLeastJump);
constexpr std::array<std::uint8_t, kJumpTables> JumpTables() {
  std::array<std::uint8_t, kJumpTables> jumps{};
  for (int apart = 0; apart < kJumpTables; ++apart)
    jumps[std::size_t(apart)] = std::uint8_t(std::max(kLeastJump, kJumpScale / (kGreyOfJump + apart)));
  return jumps;
}
alignas(16) constexpr std::array<std::uint8_t, kJumpTables> kJumps = JumpTables();

#if HWY_TARGET == HWY_SCALAR  // processors without vectors have no tables and no halves of them either

void JumpRow(const std::uint8_t* here, const std::uint8_t* before, int sense, int width, std::uint8_t* jumps) {
  for (int x = 0; x < width; ++x)
    for (const std::uint8_t* from : {here - sense, before - sense, before, before + sense})
      *jumps++ = kJumps[std::size_t(std::min(std::abs(here[x] - from[x]), kJumpTables - 1))];
}

void SweepRow(RowOfSweep& row, int from, int to) {
  const int stride = row.stride;
  for (int i = from; i < to; ++i) {
    const int x = row.sense > 0 ? i : row.width - 1 - i;
    const std::uint8_t* costs = row.costs + std::size_t(x - row.costs_from) * std::size_t(stride);
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
      row.now.smallest[(x + 1) * 4 + 1 + p] =
          path(row.before.costs + PathRow::offset(column, p, stride), row.before.smallest[(column + 1) * 4 + 1 + p],
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

void JumpRow(const std::uint8_t* HWY_RESTRICT here, const std::uint8_t* HWY_RESTRICT before, int sense, int width,
             std::uint8_t* HWY_RESTRICT jumps) {
  const hn::CappedTag<std::uint8_t, 64> d;
  const auto few = hn::LoadDup128(d, kJumps.data()), many = hn::LoadDup128(d, kJumps.data() + 16);
  const auto last = hn::Set(d, kJumpTables - 1), bit = hn::Set(d, 16);
  for (int x = 0; x < width; x += int(hn::Lanes(d))) {
    const auto own = hn::LoadU(d, here + x);
    const auto jump = [&](const std::uint8_t* from) {
      const auto other = hn::LoadU(d, from + x);
      const auto apart = hn::Min(hn::Or(hn::SaturatedSub(own, other), hn::SaturatedSub(other, own)), last);
      const auto index = hn::AndNot(bit, apart);
      return hn::IfThenElse(hn::TestBit(apart, bit), hn::TableLookupBytes(many, index),
                            hn::TableLookupBytes(few, index));
    };
    hn::StoreInterleaved4(jump(here - sense), jump(before - sense), jump(before), jump(before + sense), d,
                          jumps + 4 * x);
  }
}

// The least lane of each of four vectors of bytes: they fill every 32 bits of the result.
template <class D, class V = hn::Vec<D> >
HWY_INLINE V SmallestOfEach(D d, V a, V b, V c, V e) {
  const hn::Repartition<std::uint16_t, D> d16;
  const hn::Repartition<std::uint32_t, D> d32;
  const auto ab = hn::BitCast(d16, hn::Min(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b)));
  const auto ce = hn::BitCast(d16, hn::Min(hn::InterleaveLower(d, c, e), hn::InterleaveUpper(d, c, e)));
  auto least =
      hn::Min(hn::BitCast(d, hn::InterleaveLower(d16, ab, ce)), hn::BitCast(d, hn::InterleaveUpper(d16, ab, ce)));
  if constexpr (hn::MaxLanes(D()) > 32) least = hn::Min(least, hn::ReverseBlocks(d, least));
  if constexpr (hn::MaxLanes(D()) > 16) least = hn::Min(least, hn::SwapAdjacentBlocks(least));
  least = hn::Min(least, hn::BitCast(d, hn::Shuffle1032(hn::BitCast(d32, least))));
  return hn::Min(least, hn::BitCast(d, hn::Shuffle2301(hn::BitCast(d32, least))));
}

template <class D>
HWY_INLINE hn::TFromD<D> SmallestLane(D d, hn::Vec<D> v) {
  if constexpr (hn::MaxLanes(D()) * sizeof(hn::TFromD<D>) > 16) {
    const hn::Half<D> half;
    return SmallestLane(half, hn::Min(hn::LowerHalf(half, v), hn::UpperHalf(half, v)));
  } else {
    return hn::GetLane(hn::MinOfLanes(d, v));
  }
}

// Where each word of a vector comes from when all of it moves by a block of 16 bytes, upwards or downwards; and what
// comes in: 255 everywhere.
template <bool kUpwards, std::size_t kWords>
struct BlockMove {
  alignas(64) std::array<std::int32_t, kWords> from{};
  alignas(64) std::array<std::uint32_t, kWords> in{};
  constexpr BlockMove() {
    for (std::size_t word = 0; word < kWords; ++word) {
      const bool comes_in = kUpwards ? word < 4 : word + 4 >= kWords;
      from[word] = int(comes_in ? word : kUpwards ? word - 4 : word + 4);
      in[word] = comes_in ? 0xFFFFFFFFu : 0;
    }
  }
};

// Each lane from the one before it, the first 255; or from the one after it, the last 255.
template <bool kBefore, class D>
HWY_INLINE hn::Vec<D> Neighbour(D d, hn::Vec<D> v) {
  auto block = hn::Set(d, 255);  // the neighbouring 16 bytes
  if constexpr (hn::MaxLanes(D()) > 16) {
    const hn::Repartition<std::uint32_t, D> d32;
    static constexpr BlockMove<kBefore, hn::MaxLanes(D()) / 4> kMove;
    const auto moved = hn::TableLookupLanes(hn::BitCast(d32, v), hn::SetTableIndices(d32, kMove.from.data()));
    block = hn::BitCast(d, hn::Or(moved, hn::Load(d32, kMove.in.data())));
  }
  if constexpr (kBefore) return hn::CombineShiftRightBytes<15>(d, v, block);
  return hn::CombineShiftRightBytes<1>(d, block, v);
}

// What the path has to pay beyond its least cost to get to a pixel.
template <class D>
struct Arrival {
  hn::Vec<D> smallest, jump, small;

  Arrival(D d, hn::Vec<D> least, std::uint8_t large, hn::Vec<D> change)
      : smallest(least), jump(hn::SaturatedAdd(hn::Set(d, large), least)), small(change) {}

  HWY_INLINE hn::Vec<D> toll(hn::Vec<D> own, hn::Vec<D> below, hn::Vec<D> above) const {
    const auto near = hn::Min(own, hn::SaturatedAdd(hn::Min(below, above), small));
    return hn::Sub(hn::Min(near, jump), smallest);
  }
  HWY_INLINE hn::Vec<D> toll(D d, const std::uint8_t* costs) const {
    return toll(hn::LoadU(d, costs), hn::LoadU(d, costs - 1), hn::LoadU(d, costs + 1));
  }
};

// Where the first of the sums is that equals `least`, which is one of them; all are less than 32768. kWhole: it is
// within the first vector of bytes.
template <bool kWhole, class D, class D16>
HWY_INLINE int FirstEqual(D d, D16 d16, const std::uint16_t* sums, std::uint16_t least) {
  const hn::Half<D> half;
  const hn::RebindToSigned<D16> i16;
  const auto wanted = hn::Set(d16, least);
  const auto beyond = [&](const std::uint16_t* from) {
    return hn::DemoteTo(half, hn::BitCast(i16, hn::Sub(hn::LoadU(d16, from), wanted)));
  };
  for (int k = 0;; k += int(hn::Lanes(d))) {
    const auto bytes = hn::Combine(d, beyond(sums + k + hn::Lanes(d16)), beyond(sums + k));
    const auto equal = hn::Eq(bytes, hn::Zero(d));
    if constexpr (kWhole) {
      return int(hn::FindKnownFirstTrue(d, equal));
    } else {
      if (const auto at = hn::FindFirstTrue(d, equal); at >= 0) return k + int(at);
    }
  }
}

// The sums of all eight paths: tolls of those downwards and upwards, and eight times the cost.
template <class V16>
struct Halves {
  V16 low, high;
};
template <class D, class D16 = hn::Repartition<std::uint16_t, D> >
HWY_INLINE Halves<hn::Vec<D16> > EightfoldSums(D /*d*/, hn::Vec<D> cost, hn::Vec<D> tolls, hn::Vec<D> tolls_below) {
  const hn::Half<D> half;
  const D16 d16;
  const auto sum = [&](auto part) {
    const auto both = hn::Add(hn::PromoteTo(d16, part(tolls)), hn::PromoteTo(d16, part(tolls_below)));
    return hn::Add(both, hn::ShiftLeft<3>(hn::PromoteTo(d16, part(cost))));
  };
  return {sum([&](auto v) { return hn::LowerHalf(half, v); }), sum([&](auto v) { return hn::UpperHalf(half, v); })};
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

// kWhole: the labels of a pixel are one vector; then the path along the row stays in registers.
template <int kLanes, bool kUp, bool kWhole>
HWY_INLINE void SweepColumns(RowOfSweep& of_row, int from, int to) {
  const RowOfSweep row = of_row;  // a copy: writing bytes might change the other for all that the compiler knows
  const hn::CappedTag<std::uint8_t, kLanes> d;
  using D = decltype(d);
  const hn::Repartition<std::uint16_t, D> d16;
  const hn::Repartition<std::uint32_t, D> d32;
  const int lanes = int(hn::Lanes(d)), stride = kWhole ? lanes : row.stride;
  const int behind = kUp ? 1 : -1, ahead = -behind;
  const auto side_buffer = [&](int i) { return row.side + (i & 1 ? stride + 2 * kPathGuard : 0) + kPathGuard; };
  auto along = hn::LoadU(d, side_buffer(from));
  auto side_smallest = hn::Set(d, row.side_smallest);
  for (int i = from; i < to; ++i) {
    const int x = kUp ? row.width - 1 - i : i;
    const std::uint8_t* large = row.large + x * 4;
    const std::uint8_t* from_side = side_buffer(i);
    std::uint8_t* to_side = side_buffer(i + 1);
    const auto small = hn::Set(d, row.small[x]);
    const auto arrival = [&](int column, int p) {
      return Arrival<D>(d, hn::Set(d, row.before.smallest[(column + 1) * 4 + 1 + p]), large[p + 1], small);
    };
    const Arrival<D> side(d, side_smallest, large[0], small);
    const Arrival<D> oblique = arrival(x + behind, 0), straight = arrival(x, 1), other = arrival(x + ahead, 2);
    const std::uint8_t* from_oblique = row.before.costs + PathRow::offset(x + behind, 0, stride);
    const std::uint8_t* from_straight = row.before.costs + PathRow::offset(x, 1, stride);
    const std::uint8_t* from_other = row.before.costs + PathRow::offset(x + ahead, 2, stride);
    std::uint8_t* to_oblique = row.now.costs + PathRow::offset(x, 0, stride);
    std::uint8_t* to_straight = row.now.costs + PathRow::offset(x, 1, stride);
    std::uint8_t* to_other = row.now.costs + PathRow::offset(x, 2, stride);
    const std::uint8_t* costs = row.costs + std::size_t(x - row.costs_from) * std::size_t(stride);
    std::uint8_t* tolls = row.tolls + std::size_t(x) * std::size_t(stride);
    std::uint16_t* right_sum = kUp ? row.right_sum + row.width - 1 - x : nullptr;
    std::uint16_t* right_label = kUp ? row.right_label + row.width - 1 - x : nullptr;
    auto least0 = hn::Set(d, 255), least1 = least0, least2 = least0, least3 = least0;
    auto least_sum = hn::Set(d16, 0xFFFF);
    for (int k = 0; k < stride; k += lanes) {
      const auto cost = hn::LoadU(d, costs + k);
      hn::Vec<D> t0;
      if constexpr (kWhole)
        t0 = side.toll(along, Neighbour<true>(d, along), Neighbour<false>(d, along));
      else
        t0 = side.toll(d, from_side + k);
      const auto t1 = oblique.toll(d, from_oblique + k), t2 = straight.toll(d, from_straight + k);
      const auto t3 = other.toll(d, from_other + k);
      const auto v0 = hn::SaturatedAdd(t0, cost), v1 = hn::SaturatedAdd(t1, cost);
      const auto v2 = hn::SaturatedAdd(t2, cost), v3 = hn::SaturatedAdd(t3, cost);
      least0 = hn::Min(least0, v0), least1 = hn::Min(least1, v1);
      least2 = hn::Min(least2, v2), least3 = hn::Min(least3, v3);
      if constexpr (kWhole)
        along = v0;
      else
        hn::StoreU(v0, d, to_side + k);
      hn::StoreU(v1, d, to_oblique + k);
      hn::StoreU(v2, d, to_straight + k);
      hn::StoreU(v3, d, to_other + k);
      const auto sum_of_tolls = hn::Add(hn::Add(t0, t1), hn::Add(t2, t3));
      if constexpr (kUp) {
        const auto [low, high] = EightfoldSums(d, cost, sum_of_tolls, hn::LoadU(d, tolls + k));
        least_sum = hn::Min(least_sum, hn::Min(low, high));
        SeeFromTheRight(d16, low, k, right_sum, right_label);
        SeeFromTheRight(d16, high, k + lanes / 2, right_sum, right_label);
        hn::StoreU(low, d16, row.sums + k);
        hn::StoreU(high, d16, row.sums + k + lanes / 2);
      } else {
        hn::StoreU(sum_of_tolls, d, tolls + k);
      }
    }
    const auto least = SmallestOfEach(d, least0, least1, least2, least3);
    side_smallest = hn::TableLookupBytes(least, hn::Zero(d));
    const std::uint32_t four = hn::GetLane(hn::BitCast(d32, least));  // that from the side is the lowest byte
    std::memcpy(row.now.smallest + (x + 1) * 4, &four, sizeof four);
    if constexpr (kUp) {
      const int k = FirstEqual<kWhole>(d, d16, row.sums, SmallestLane(d16, least_sum));
      row.best[x] = {std::uint16_t(k), k > 0 ? row.sums[k - 1] : std::uint16_t(0xFFFF), row.sums[k],
                     k + 1 < row.labels ? row.sums[k + 1] : std::uint16_t(0xFFFF)};
    }
  }
  if constexpr (kWhole) hn::StoreU(along, d, side_buffer(to));
  of_row.side_smallest = hn::GetLane(side_smallest);
}

template <int kLanes, bool kUp>
HWY_INLINE void SweepLabels(RowOfSweep& row, int from, int to) {
  if (row.stride == int(hn::Lanes(hn::CappedTag<std::uint8_t, kLanes>())))
    SweepColumns<kLanes, kUp, true>(row, from, to);
  else
    SweepColumns<kLanes, kUp, false>(row, from, to);
}

void SweepRow(RowOfSweep& row, int from, int to) {
  const bool wide = row.stride % 64 == 0, up = row.sense < 0;
  if (wide && up) return SweepLabels<64, true>(row, from, to);
  if (wide) return SweepLabels<64, false>(row, from, to);
  if (up) return SweepLabels<32, true>(row, from, to);
  SweepLabels<32, false>(row, from, to);
}

#endif  // HWY_TARGET == HWY_SCALAR

void DisparitiesOfRow(const FoundRow& row, float* HWY_RESTRICT disparity) {
  const hn::CappedTag<float, 16> f;
  const hn::RebindToSigned<decltype(f)> i;
  const hn::Rebind<std::uint16_t, decltype(f)> d16;
  const hn::Rebind<std::uint8_t, decltype(f)> d8;
  const auto zero = hn::Zero(i), none = hn::Set(i, 0xFFFF);
  for (int x = 0; x < row.width; x += int(hn::Lanes(f))) {
    hn::Vec<decltype(d16)> label16, before16, at16, after16;
    hn::LoadInterleaved4(d16, &row.best[x].label, label16, before16, at16, after16);
    const auto column = hn::Iota(i, x);
    const auto label = hn::PromoteTo(i, label16);
    const auto right = hn::Sub(hn::Sub(column, hn::Set(i, row.low)), label);
    const auto index = hn::Add(hn::Sub(hn::Set(i, row.width - 1), column), label);
    const auto safe = hn::Min(hn::Max(index, zero), hn::Set(i, row.right_size - 1));
    const auto words =
        hn::GatherOffset(i, reinterpret_cast<const std::int32_t*>(row.right_label), hn::ShiftLeft<1>(safe));
    const auto apart = hn::Abs(hn::Sub(hn::And(words, none), label));
    const auto there = hn::AndNot(hn::Lt(right, hn::Set(i, row.first_right)), hn::Lt(right, hn::Set(i, row.end_right)));
    const auto seen = hn::Gt(hn::PromoteTo(i, hn::LoadU(d8, row.left + x)), zero);
    const auto good = hn::And(hn::And(there, seen), hn::Lt(apart, hn::Set(i, row.max_apart + 1)));
    const auto before = hn::PromoteTo(i, before16), at = hn::PromoteTo(i, at16), after = hn::PromoteTo(i, after16);
    const auto rise_before = hn::ConvertTo(f, hn::Sub(before, at)), rise_after = hn::ConvertTo(f, hn::Sub(after, at));
    const auto both = hn::Add(rise_before, rise_after);
    const auto between =
        hn::And(hn::RebindMask(f, hn::And(hn::Ne(before, none), hn::Ne(after, none))), hn::Gt(both, hn::Zero(f)));
    const auto off = hn::Div(hn::Mul(hn::Set(f, 0.5f), hn::Sub(rise_before, rise_after)), both);
    const auto value =
        hn::Add(hn::Set(f, float(row.low)), hn::Add(hn::ConvertTo(f, label), hn::IfThenElseZero(between, off)));
    hn::StoreU(hn::IfThenElse(hn::RebindMask(f, good), value, hn::NaN(f)), f, disparity + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {

HWY_EXPORT(CensusRow);
HWY_EXPORT(CensusCosts);
HWY_EXPORT(JumpRow);
HWY_EXPORT(SweepRow);
HWY_EXPORT(DisparitiesOfRow);

void census_row(const std::uint8_t* const* rows, int width, bool mirrored, const CensusRows<std::uint8_t>& census) {
  HWY_DYNAMIC_DISPATCH(CensusRow)(rows, width, mirrored, census);
}

void census_costs(const CensusRows<const std::uint8_t>& left, const CensusRows<const std::uint8_t>& right, int width,
                  int labels, int stride, int chance, std::uint8_t* costs) {
  HWY_DYNAMIC_DISPATCH(CensusCosts)(left, right, width, labels, stride, chance, costs);
}

void jump_row(const std::uint8_t* here, const std::uint8_t* before, int sense, int width, std::uint8_t* jumps) {
  HWY_DYNAMIC_DISPATCH(JumpRow)(here, before, sense, width, jumps);
}

void disparities_of_row(const FoundRow& row, float* disparity) {
  HWY_DYNAMIC_DISPATCH(DisparitiesOfRow)(row, disparity);
}

void sweep_columns(RowOfSweep& row, int from, int to) { HWY_DYNAMIC_DISPATCH(SweepRow)(row, from, to); }

}  // namespace collinea::dense
#endif  // HWY_ONCE
