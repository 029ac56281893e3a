// SPDX-License-Identifier: Apache-2.0
// Squared distances |a|^2 + |b|^2 - 2 a.b of all pairs, tile by tile, each tile reduced at once to the nearest two by
// row and by column. A tile is kRows descriptors of a times a panel of kVectors vectors of b, one descriptor of b in
// each lane.
//
// The dot products are exact. Bytes are widened to 16 bits and multiplied in pairs. Where there are byte dot products
// (VNNI: unsigned times signed), a - 128 takes the place of a, and a.b = (a - 128).b + 128 sum(b). Where there are
// sums of two byte products in 16 bits (AVX2) and no byte is beyond 127, as in our own descriptors, so does a - 64: the
// sum of four such products is at most 4 * 64 * 127 = 32512 and still fits.
#include "collinea/match/internal/descriptors_kernels.h"

// Arrays of vectors need vectors of known size; the narrowest x86 target is not worth its code.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#define HWY_WANT_AVX3_DL
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/match/internal/descriptors_kernels.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/aligned_allocator.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<std::int32_t>;
using V = hn::Vec<D>;

constexpr D kInts;
constexpr std::size_t kSize = 128;  // bytes of a descriptor
constexpr std::size_t kLanes = hn::MaxLanes(kInts);
constexpr std::size_t kRows = 4;
constexpr std::size_t kTileRows = 256;             // rows whose running minima stay in the cache
constexpr std::int32_t kFar = 1 << 29;             // beyond any distance (128 * 255^2 < 2^23): marks padding
constexpr std::int32_t kUnset = (1 << 30) + kFar;  // not below any value computed, padding included
#if HWY_TARGET <= HWY_AVX3
constexpr std::size_t kVectors = 4;
#else
constexpr std::size_t kVectors = 2;
#endif
constexpr std::size_t kPanel = kVectors * kLanes;

// How dot products are made: the elements of a and of b, what a is lowered by, and how many groups of elements (one in
// each lane) are multiplied and added at once.
#if HWY_TARGET == HWY_AVX3_DL
struct ByteProducts {
  using Element = std::uint8_t;
  static constexpr std::int32_t kOffset = 128;
  static constexpr std::size_t kTogether = 1;

  // Highway tests the machine for AVX512-VNNI before it takes this target, but does not tell the compiler: hence no
  // intrinsic.
  static HWY_INLINE V add(V sum, const V* a, const V* b) {
    asm("vpdpbusd %2, %1, %0" : "+v"(sum.raw) : "v"(b->raw), "v"(a->raw));
    return sum;
  }
};
using Products = ByteProducts;
#elif HWY_TARGET == HWY_SCALAR
struct PlainProducts {
  using Element = std::int32_t;
  static constexpr std::int32_t kOffset = 0;
  static constexpr std::size_t kTogether = 1;

  static HWY_INLINE V add(V sum, const V* a, const V* b) { return hn::Add(sum, hn::Mul(*a, *b)); }
};
using Products = PlainProducts;
#else
struct WideProducts {
  using Element = std::int16_t;
  static constexpr std::int32_t kOffset = 0;
  static constexpr std::size_t kTogether = 1;

  static HWY_INLINE V add(V sum, const V* a, const V* b) {
    const hn::Repartition<std::int16_t, D> shorts;
    V unused = hn::Zero(kInts);
    return hn::ReorderWidenMulAccumulate(kInts, hn::BitCast(shorts, *a), hn::BitCast(shorts, *b), sum, unused);
  }
};
using Products = WideProducts;
#endif
#if HWY_TARGET == HWY_AVX2
struct SevenBitProducts {
  using Element = std::uint8_t;
  static constexpr std::int32_t kOffset = 64;
  static constexpr std::size_t kTogether = 2;

  static HWY_INLINE V add(V sum, const V* a, const V* b) {
    const __m256i four =
        _mm256_add_epi16(_mm256_maddubs_epi16(b[0].raw, a[0].raw), _mm256_maddubs_epi16(b[1].raw, a[1].raw));
    return hn::Add(sum, V{_mm256_madd_epi16(four, _mm256_set1_epi16(1))});
  }
};
#endif

// A tile's sums stay in registers only when its loops are written out; -O2 does not do that by itself.
#undef COLLINEA_UNROLL
#define COLLINEA_UNROLL _Pragma("GCC unroll 4")
#undef COLLINEA_UNROLL_ALL
#define COLLINEA_UNROLL_ALL _Pragma("GCC unroll 16")

// Elements of neighbouring dimensions that one lane holds, and lanes that a descriptor fills.
template <class P>
constexpr std::size_t kGroup = sizeof(std::int32_t) / sizeof(typename P::Element);
template <class P>
constexpr std::size_t kSteps = kSize / kGroup<P>;

HWY_INLINE std::size_t padded(std::size_t count, std::size_t step) { return (count + step - 1) / step * step; }

HWY_INLINE std::int32_t squared_norm(const std::uint8_t* descriptor) {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < kSize; ++i) sum += std::int32_t{descriptor[i]} * descriptor[i];
  return sum;
}

HWY_INLINE std::int32_t sum_of(const std::uint8_t* descriptor) {
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < kSize; ++i) sum += descriptor[i];
  return sum;
}

// Rows of a as they are multiplied, and what each adds to its distances.
template <class P>
void pack_rows(const std::uint8_t* a, std::size_t count, typename P::Element* packed, std::int32_t* constants) {
  for (std::size_t i = 0; i < padded(count, kRows); ++i) {
    for (std::size_t k = 0; k < kSize; ++k)
      packed[i * kSize + k] = static_cast<typename P::Element>((i < count ? a[i * kSize + k] : 0) - P::kOffset);
    constants[i] = i < count ? squared_norm(a + i * kSize) : kFar;
  }
}

// Panels of b: for each group of dimensions the groups of all its descriptors side by side.
template <class P>
void pack_columns(const std::uint8_t* b, std::size_t count, typename P::Element* packed, std::int32_t* constants) {
  using Element = typename P::Element;
  for (std::size_t j = 0; j < padded(count, kPanel); ++j) {
    Element* column = packed + j / kPanel * kPanel * kSize + j % kPanel * kGroup<P>;
    for (std::size_t k = 0; k < kSize; ++k)
      column[k / kGroup<P> * kPanel * kGroup<P> + k % kGroup<P>] = j < count ? b[j * kSize + k] : Element{0};
    constants[j] = j < count ? squared_norm(b + j * kSize) - 2 * P::kOffset * sum_of(b + j * kSize) : kFar;
  }
}

// The running nearest two of a vector of searches, as it lies in memory: best, second, index.
struct Running {
  V best, second, index;

  static HWY_INLINE Running load(const std::int32_t* from) {
    return {hn::Load(kInts, from), hn::Load(kInts, from + kLanes), hn::Load(kInts, from + 2 * kLanes)};
  }
  HWY_INLINE void store(std::int32_t* to) const {
    hn::Store(best, kInts, to);
    hn::Store(second, kInts, to + kLanes);
    hn::Store(index, kInts, to + 2 * kLanes);
  }
  HWY_INLINE void add(V distance, V candidate) {
    index = hn::IfThenElse(hn::Lt(distance, best), candidate, index);
    second = hn::Min(second, hn::Max(best, distance));
    best = hn::Min(best, distance);
  }
};
constexpr std::size_t kRunning = 3 * kLanes;

void clear(std::int32_t* running, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    Running{hn::Set(kInts, kUnset), hn::Set(kInts, kUnset), hn::Zero(kInts)}.store(running + i * kRunning);
}

template <class P>
struct Rows {
  const typename P::Element* packed;
  const std::int32_t* constants;
  std::int32_t* running;  // kRunning for each row
};
template <class P>
struct Panel {
  const typename P::Element* packed;
  const std::int32_t* constants;
  std::int32_t* running;  // kRunning for each vector
};

template <class P>
HWY_INLINE void match_tile(const Rows<P>& rows, std::int32_t first_row, const Panel<P>& panel,
                           std::int32_t first_column) {
  constexpr std::size_t kTogether = P::kTogether;
  V dot[kRows][kVectors];
  COLLINEA_UNROLL
  for (std::size_t r = 0; r < kRows; ++r) COLLINEA_UNROLL
  for (std::size_t v = 0; v < kVectors; ++v) dot[r][v] = hn::Zero(kInts);
  for (std::size_t k = 0; k < kSteps<P>; k += kTogether) {
    V b[kVectors][kTogether];
    COLLINEA_UNROLL
    for (std::size_t v = 0; v < kVectors; ++v) COLLINEA_UNROLL
    for (std::size_t t = 0; t < kTogether; ++t)
      b[v][t] = hn::Load(kInts, reinterpret_cast<const std::int32_t*>(panel.packed) + (k + t) * kPanel + v * kLanes);
    COLLINEA_UNROLL
    for (std::size_t r = 0; r < kRows; ++r) {
      V a[kTogether];
      COLLINEA_UNROLL
      for (std::size_t t = 0; t < kTogether; ++t)
        a[t] = hn::Set(kInts, reinterpret_cast<const std::int32_t*>(rows.packed)[r * kSteps<P> + k + t]);
      COLLINEA_UNROLL
      for (std::size_t v = 0; v < kVectors; ++v) dot[r][v] = P::add(dot[r][v], a, b[v]);
    }
  }
  Running of_column[kVectors];
  COLLINEA_UNROLL
  for (std::size_t v = 0; v < kVectors; ++v) of_column[v] = Running::load(panel.running + v * kRunning);
  COLLINEA_UNROLL
  for (std::size_t r = 0; r < kRows; ++r) {
    Running of_row = Running::load(rows.running + r * kRunning);
    const V row = hn::Set(kInts, first_row + static_cast<std::int32_t>(r)),
            constant = hn::Set(kInts, rows.constants[r]);
    COLLINEA_UNROLL
    for (std::size_t v = 0; v < kVectors; ++v) {
      const V sum = hn::Add(constant, hn::Load(kInts, panel.constants + v * kLanes));
      const V distance = hn::Sub(sum, hn::ShiftLeft<1>(dot[r][v]));
      of_column[v].add(distance, row);
      of_row.add(distance, hn::Iota(kInts, first_column + static_cast<std::int32_t>(v * kLanes)));
    }
    of_row.store(rows.running + r * kRunning);
  }
  COLLINEA_UNROLL
  for (std::size_t v = 0; v < kVectors; ++v) of_column[v].store(panel.running + v * kRunning);
}

HWY_INLINE std::int32_t none_if_far(std::int32_t distance) { return distance < kFar ? distance : NearestTwo::kNone; }

// One search from the lanes that took part in it.
NearestTwo gathered(const std::int32_t* running) {
  std::int32_t best = kUnset, second = kUnset, index = 0;
  for (std::size_t i = 0; i < kLanes; ++i) {
    const std::int32_t lane_best = running[i], lane_index = running[2 * kLanes + i];
    second = HWY_MIN(second, HWY_MIN(running[kLanes + i], HWY_MAX(best, lane_best)));
    if (lane_best < best || (lane_best == best && lane_index < index)) index = lane_index;
    best = HWY_MIN(best, lane_best);
  }
  return {static_cast<std::uint32_t>(index), none_if_far(best), none_if_far(second)};
}

template <class P>
void nearest_two_by(const std::uint8_t* a, std::size_t count_a, const std::uint8_t* b, std::size_t count_b,
                    NearestTwo* of_a, NearestTwo* of_b) {
  using Element = typename P::Element;
  const std::size_t rows = padded(count_a, kRows), columns = padded(count_b, kPanel);
  const auto packed_a = hwy::AllocateAligned<Element>(rows * kSize),
             packed_b = hwy::AllocateAligned<Element>(columns * kSize);
  const auto constants_a = hwy::AllocateAligned<std::int32_t>(rows),
             constants_b = hwy::AllocateAligned<std::int32_t>(columns);
  const auto running_a = hwy::AllocateAligned<std::int32_t>(kTileRows * kRunning);
  const auto running_b = hwy::AllocateAligned<std::int32_t>(columns / kLanes * kRunning);
  pack_rows<P>(a, count_a, packed_a.get(), constants_a.get());
  pack_columns<P>(b, count_b, packed_b.get(), constants_b.get());
  clear(running_b.get(), columns / kLanes);

  for (std::size_t tile = 0; tile < rows; tile += kTileRows) {
    const std::size_t tile_end = HWY_MIN(tile + kTileRows, rows);
    clear(running_a.get(), kTileRows);
    for (std::size_t j = 0; j < columns; j += kPanel) {
      const Panel<P> panel{packed_b.get() + j * kSize, constants_b.get() + j, running_b.get() + j / kLanes * kRunning};
      for (std::size_t i = tile; i < tile_end; i += kRows)
        match_tile<P>({packed_a.get() + i * kSize, constants_a.get() + i, running_a.get() + (i - tile) * kRunning},
                      static_cast<std::int32_t>(i), panel, static_cast<std::int32_t>(j));
    }
    for (std::size_t i = tile; i < HWY_MIN(tile_end, count_a); ++i)
      of_a[i] = gathered(running_a.get() + (i - tile) * kRunning);
  }
  for (std::size_t j = 0; j < count_b; ++j) {
    const std::int32_t* lane = running_b.get() + j / kLanes * kRunning + j % kLanes;
    of_b[j] = {static_cast<std::uint32_t>(lane[2 * kLanes]), none_if_far(lane[0]), none_if_far(lane[kLanes])};
  }
}

#if HWY_TARGET == HWY_AVX2
bool has_seven_bits(const std::uint8_t* descriptors, std::size_t count) {
  std::uint8_t bits = 0;
  for (std::size_t i = 0; i < count * kSize; ++i) bits |= descriptors[i];
  return bits <= 127;
}
#endif

void nearest_two(const std::uint8_t* a, std::size_t count_a, const std::uint8_t* b, std::size_t count_b,
                 NearestTwo* of_a, NearestTwo* of_b) {
#if HWY_TARGET == HWY_AVX2
  if (has_seven_bits(a, count_a) && has_seven_bits(b, count_b))
    return nearest_two_by<SevenBitProducts>(a, count_a, b, count_b, of_a, of_b);
#endif
  nearest_two_by<Products>(a, count_a, b, count_b, of_a, of_b);
}

#if HWY_TARGET == HWY_SCALAR
void squared_distances(const std::uint8_t* one, const std::uint8_t* all, const std::uint32_t* which, std::size_t count,
                       std::int32_t* distances) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* other = all + which[i] * kSize;
    std::int32_t sum = 0;
    for (std::size_t k = 0; k < kSize; ++k) {
      const std::int32_t difference = std::int32_t{one[k]} - other[k];
      sum += difference * difference;
    }
    distances[i] = sum;
  }
}

void dot_products(const std::int8_t* one, const std::int8_t* all, std::size_t length, std::size_t count,
                  std::int32_t* products) {
  for (std::size_t k = 0; k < count; ++k) {
    products[k] = 0;
    for (std::size_t i = 0; i < length; ++i) products[k] += std::int32_t{one[i]} * all[k * length + i];
  }
}
#else
void squared_distances(const std::uint8_t* one, const std::uint8_t* all, const std::uint32_t* which, std::size_t count,
                       std::int32_t* distances) {
  const hn::Repartition<std::int16_t, D> shorts;
  const hn::Rebind<std::uint8_t, decltype(shorts)> bytes;
  constexpr std::size_t kParts = kSize / (2 * kLanes);
  hn::Vec<decltype(shorts)> widened[kParts];
  COLLINEA_UNROLL_ALL
  for (std::size_t p = 0; p < kParts; ++p) widened[p] = hn::PromoteTo(shorts, hn::LoadU(bytes, one + p * 2 * kLanes));
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* other = all + which[i] * kSize;
    V even = hn::Zero(kInts), odd = hn::Zero(kInts);
    COLLINEA_UNROLL_ALL
    for (std::size_t p = 0; p < kParts; ++p) {
      const auto difference = hn::Sub(hn::PromoteTo(shorts, hn::LoadU(bytes, other + p * 2 * kLanes)), widened[p]);
      even = hn::ReorderWidenMulAccumulate(kInts, difference, difference, even, odd);
    }
    distances[i] = hn::GetLane(hn::SumOfLanes(kInts, hn::Add(even, odd)));
  }
}

// Several at once: each part of `one` is widened for all of them.
void dot_products(const std::int8_t* one, const std::int8_t* all, std::size_t length, std::size_t count,
                  std::int32_t* products) {
  const hn::Repartition<std::int16_t, D> shorts;
  const hn::Rebind<std::int8_t, decltype(shorts)> bytes;
  for (std::size_t k = 0; k < count; k += kRows) {
    const std::int8_t* others[kRows];
    V even[kRows], odd[kRows];
    COLLINEA_UNROLL
    for (std::size_t r = 0; r < kRows; ++r) {
      others[r] = all + HWY_MIN(k + r, count - 1) * length;
      even[r] = odd[r] = hn::Zero(kInts);
    }
    for (std::size_t i = 0; i < length; i += 2 * kLanes) {
      const auto part = hn::PromoteTo(shorts, hn::LoadU(bytes, one + i));
      COLLINEA_UNROLL
      for (std::size_t r = 0; r < kRows; ++r)
        even[r] = hn::ReorderWidenMulAccumulate(kInts, part, hn::PromoteTo(shorts, hn::LoadU(bytes, others[r] + i)),
                                                even[r], odd[r]);
    }
    for (std::size_t r = 0; r < HWY_MIN(kRows, count - k); ++r)
      products[k + r] = hn::GetLane(hn::SumOfLanes(kInts, hn::Add(even[r], odd[r])));
  }
}
#endif

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {
HWY_EXPORT(nearest_two);
HWY_EXPORT(squared_distances);
HWY_EXPORT(dot_products);

void nearest_two(const std::uint8_t* a, std::size_t count_a, const std::uint8_t* b, std::size_t count_b,
                 NearestTwo* of_a, NearestTwo* of_b) {
  if (count_a == 0 || count_b == 0) {
    for (std::size_t i = 0; i < count_a; ++i) of_a[i] = {};
    for (std::size_t j = 0; j < count_b; ++j) of_b[j] = {};
    return;
  }
  HWY_DYNAMIC_DISPATCH(nearest_two)(a, count_a, b, count_b, of_a, of_b);
}

void squared_distances(const std::uint8_t* one, const std::uint8_t* all, const std::uint32_t* which, std::size_t count,
                       std::int32_t* distances) {
  HWY_DYNAMIC_DISPATCH(squared_distances)(one, all, which, count, distances);
}

void dot_products(const std::int8_t* one, const std::int8_t* all, std::size_t length, std::size_t count,
                  std::int32_t* products) {
  HWY_DYNAMIC_DISPATCH(dot_products)(one, all, length, count, products);
}
}  // namespace collinea
#endif
