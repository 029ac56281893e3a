// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/match_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/internal/match_kernels.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

// Products and sums are kept apart (no fused multiply-add): then every processor gives the same bits.

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, 16>;
using I = hn::Rebind<std::int32_t, F>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;
constexpr F f;
constexpr I i32;

// Positions in Quads, in 1/64 px from its first element.
struct Sampled {
  VF x, y;
};

HWY_INLINE Sampled sampled(const Quads& quads, const Carried& carried, int i, VF dx, VF dy, VF dz) {
  const VF z = hn::Add(hn::Load(f, carried.z + i), dz);
  const VF scale = hn::Div(hn::Set(f, 64.0f), z);
  const auto in_front = hn::Gt(z, hn::Set(f, 1e-6f));
  const VF x = hn::Add(hn::Mul(hn::Add(hn::Load(f, carried.x + i), dx), scale), hn::Set(f, 32.0f));
  const VF y = hn::Add(hn::Mul(hn::Add(hn::Load(f, carried.y + i), dy), scale), hn::Set(f, 32.0f));
  const VF zero = hn::Zero(f);
  const VF x_end = hn::Set(f, float(quads.width * 64 + 63)), y_end = hn::Set(f, float(quads.height * 64 + 63));
  return {hn::Min(hn::Max(hn::IfThenElseZero(in_front, x), zero), x_end),
          hn::Min(hn::Max(hn::IfThenElseZero(in_front, y), zero), y_end)};
}

void SampleBytes(const Quads& quads, const Carried& carried, float dx, float dy, float dz, std::int8_t* out) {
  const hn::Rebind<std::uint8_t, F> narrow;
  const VF vx = hn::Set(f, dx), vy = hn::Set(f, dy), vz = hn::Set(f, dz);
  const VI stride = hn::Set(i32, quads.width + 1), low_bits = hn::Set(i32, 63), bytes = hn::Set(i32, 0x00FF00FF);
  for (int i = 0; i < kRegion; i += int(hn::Lanes(f))) {
    const Sampled at = sampled(quads, carried, i, vx, vy, vz);
    const VF half = hn::Set(f, 0.5f);
    const VI x = hn::ConvertTo(i32, hn::Add(at.x, half)), y = hn::ConvertTo(i32, hn::Add(at.y, half));
    const VI index = hn::Add(hn::Mul(hn::ShiftRight<6>(y), stride), hn::ShiftRight<6>(x));
    const VI quad = hn::GatherIndex(i32, quads.data.data(), index);
    const VI wx = hn::And(x, low_bits), wy = hn::And(y, low_bits);
    // both rows at once in the halves of 32 bits (255 * 64 fits into 16), then between the rows
    const VI left = hn::And(quad, bytes), right = hn::And(hn::ShiftRight<8>(quad), bytes);
    const VI rows = hn::Add(hn::Mul(left, hn::Sub(hn::Set(i32, 64), wx)), hn::Mul(right, wx));
    const VI top = hn::And(rows, hn::Set(i32, 0xFFFF)), bottom = hn::ShiftRight<16>(rows);
    const VI sum = hn::Add(hn::ShiftLeft<6>(top), hn::Mul(hn::Sub(bottom, top), wy));
    const VI grey = hn::ShiftRight<12>(hn::Add(sum, hn::Set(i32, 2048)));
    const auto packed = hn::Xor(hn::DemoteTo(narrow, grey), hn::Set(narrow, 0x80));
    hn::Store(packed, narrow, reinterpret_cast<std::uint8_t*>(out) + i);
  }
}

void SampleFloats(const Quads& quads, const Carried& carried, float dx, float dy, float dz, float* out) {
  const VF vx = hn::Set(f, dx), vy = hn::Set(f, dy), vz = hn::Set(f, dz);
  const VI stride = hn::Set(i32, quads.width + 1), byte = hn::Set(i32, 0xFF);
  const VF unit = hn::Set(f, 1 / 64.0f);
  for (int i = 0; i < kRegion; i += int(hn::Lanes(f))) {
    const Sampled at = sampled(quads, carried, i, vx, vy, vz);
    const VF x = hn::Mul(at.x, unit), y = hn::Mul(at.y, unit);
    const VI column = hn::ConvertTo(i32, x), row = hn::ConvertTo(i32, y);
    const VI quad = hn::GatherIndex(i32, quads.data.data(), hn::Add(hn::Mul(row, stride), column));
    const VF wx = hn::Sub(x, hn::ConvertTo(f, column)), wy = hn::Sub(y, hn::ConvertTo(f, row));
    const VF a = hn::ConvertTo(f, hn::And(quad, byte));
    const VF b = hn::ConvertTo(f, hn::And(hn::ShiftRight<8>(quad), byte));
    const VF c = hn::ConvertTo(f, hn::And(hn::ShiftRight<16>(quad), byte));
    const VF d = hn::ConvertTo(f, hn::And(hn::ShiftRight<24>(quad), byte));
    const VF top = hn::Add(a, hn::Mul(hn::Sub(b, a), wx)), bottom = hn::Add(c, hn::Mul(hn::Sub(d, c), wx));
    const VF grey = hn::Sub(hn::Add(top, hn::Mul(hn::Sub(bottom, top), wy)), hn::Set(f, 128.0f));
    const auto missing = hn::RebindMask(f, hn::Eq(quad, hn::Zero(i32)));
    hn::Store(hn::IfThenElse(missing, hn::NaN(f), grey), f, out + i);
  }
}

void Carry(const Transfer& t, int left, int top, const float* w, Carried& carried) {
  const auto& h = t.h;
  for (int j = 0; j < kRegionHeight; ++j) {
    const float v = float(top + j) + 0.5f;
    // rows of kRegionWidth are not a whole number of the widest vectors: take them in narrower ones
    const hn::CappedTag<float, 8> n;
    for (int i = 0; i < kRegionWidth; i += int(hn::Lanes(n))) {
      const auto u = hn::Add(hn::Iota(n, 0.5f), hn::Set(n, float(left + i)));
      const auto depth = hn::LoadU(n, w + j * kRegionWidth + i);
      const auto linear = [&](float hx, float offset, float b) {
        return hn::Add(hn::Add(hn::Mul(u, hn::Set(n, hx)), hn::Set(n, offset)), hn::Mul(depth, hn::Set(n, b)));
      };
      const int at = j * kRegionWidth + i;
      hn::StoreU(linear(h[0], h[1] * v + h[2], t.b[0]), n, carried.x + at);
      hn::StoreU(linear(h[3], h[4] * v + h[5], t.b[1]), n, carried.y + at);
      hn::StoreU(linear(h[6], h[7] * v + h[8], t.b[2]), n, carried.z + at);
    }
  }
}

using B = hn::CappedTag<std::uint8_t, 32>;
using S = hn::Rebind<std::int8_t, B>;
constexpr B u8;
constexpr S i8;

// Calls visit(bit, offset, opposite offset) for the half of the window that stands for all pairs of opposite pixels.
template <class Visit>
HWY_INLINE void for_each_pair(Visit&& visit) {
  int bit = 0;
  for (int dy = -kRadius; dy <= 0; ++dy)
    for (int dx = -kRadius; dx <= (dy < 0 ? kRadius : -1); ++dx, ++bit)
      visit(bit, dy * kRegionWidth + dx, -dy * kRegionWidth - dx);
}

HWY_INLINE const std::int8_t* centre(const std::int8_t* region, int x, int y) {
  return region + (y + kRadius) * kRegionWidth + x + kRadius;
}

void Census(const std::int8_t* region, std::uint8_t* planes) {
  for (int y = 0; y < kCell; ++y)
    for (int x = 0; x < kCell; x += int(hn::Lanes(u8))) {
      const std::int8_t* p = centre(region, x, y);
      for_each_pair([&](int bit, int a, int b) {
        const auto rises = hn::VecFromMask(i8, hn::Lt(hn::LoadU(i8, p + a), hn::LoadU(i8, p + b)));
        hn::Store(hn::BitCast(u8, rises), u8, planes + bit * kCellPixels + y * kCell + x);
      });
    }
}

void CensusDistance(const std::int8_t* region, const std::uint8_t* planes, std::uint8_t* distance) {
  constexpr int kCorner = kRadius * kRegionWidth + kRadius, kOther = kRadius * kRegionWidth - kRadius;
  const auto nothing = hn::Set(i8, -128);
  for (int y = 0; y < kCell; ++y)
    for (int x = 0; x < kCell; x += int(hn::Lanes(u8))) {
      const std::int8_t* p = centre(region, x, y);
      const std::uint8_t* bits = planes + y * kCell + x;
      auto sum = hn::Zero(i8);
      for_each_pair([&](int bit, int a, int b) {
        const auto rises = hn::VecFromMask(i8, hn::Lt(hn::LoadU(i8, p + a), hn::LoadU(i8, p + b)));
        sum = hn::Sub(sum, hn::Xor(rises, hn::BitCast(i8, hn::Load(u8, bits + bit * kCellPixels))));
      });
      auto missing = hn::Eq(hn::LoadU(i8, p), nothing);
      for (const int corner : {-kCorner, -kOther, kOther, kCorner})
        missing = hn::Or(missing, hn::Eq(hn::LoadU(i8, p + corner), nothing));
      const auto value = hn::BitCast(u8, hn::Or(sum, hn::VecFromMask(i8, missing)));
      hn::Store(value, u8, distance + y * kCell + x);
    }
}

void Add(const std::uint8_t* distance, Smallest& s) {
  for (int i = 0; i < kCellPixels; i += int(hn::Lanes(u8))) {
    const auto value = hn::Load(u8, distance + i);
    const auto first = hn::Load(u8, s.first + i), second = hn::Load(u8, s.second + i),
               third = hn::Load(u8, s.third + i);
    const auto after_first = hn::Max(first, value);
    const auto after_second = hn::Max(second, after_first);
    hn::Store(hn::Min(first, value), u8, s.first + i);
    hn::Store(hn::Min(second, after_first), u8, s.second + i);
    hn::Store(hn::Min(third, after_second), u8, s.third + i);
    const auto there = hn::VecFromMask(u8, hn::Ne(value, hn::Set(u8, 255)));
    hn::Store(hn::Sub(hn::Load(u8, s.count + i), there), u8, s.count + i);
  }
}

void Cost(const Smallest& s, std::uint8_t* out) {
  for (int i = 0; i < kCellPixels; i += int(hn::Lanes(u8))) {
    const auto first = hn::Load(u8, s.first + i), second = hn::Load(u8, s.second + i),
               third = hn::Load(u8, s.third + i);
    const auto count = hn::Load(u8, s.count + i);
    const auto twice = [](auto v) { return hn::SaturatedAdd(v, v); };
    const auto one = twice(hn::SaturatedAdd(twice(first), first));
    const auto both = hn::SaturatedAdd(first, second);
    const auto two = hn::SaturatedAdd(twice(both), both);
    const auto three = twice(hn::SaturatedAdd(both, third));
    auto value = hn::Set(u8, kCostOfChance);
    value = hn::IfThenElse(hn::Eq(count, hn::Set(u8, 1)), one, value);
    value = hn::IfThenElse(hn::Gt(count, hn::Set(u8, 1)), two, value);
    value = hn::IfThenElse(hn::Gt(count, hn::Set(u8, 4)), three, value);
    hn::Store(hn::Min(value, hn::Set(u8, 254)), u8, out + i);
  }
}

// Sums over windows of `product(index)` for every pixel of the cell; first down the columns, then along the rows.
template <class Product>
HWY_INLINE void window_sums(Product&& product, float* sums) {
  const hn::CappedTag<float, 8> n;
  constexpr int kSide = 2 * kRadius + 1;
  HWY_ALIGN float columns[kRegionWidth];
  for (int y = 0; y < kCell; ++y) {
    for (int x = 0; x < kRegionWidth; x += int(hn::Lanes(n))) {
      auto sum = product(n, y * kRegionWidth + x);
      for (int j = 1; j < kSide; ++j) sum = hn::Add(sum, product(n, (y + j) * kRegionWidth + x));
      hn::Store(sum, n, columns + x);
    }
    for (int x = 0; x < kCell; x += int(hn::Lanes(n))) {
      auto sum = hn::LoadU(n, columns + x);
      for (int i = 1; i < kSide; ++i) sum = hn::Add(sum, hn::LoadU(n, columns + x + i));
      hn::Store(sum, n, sums + y * kCell + x);
    }
  }
}

constexpr float kWindowPixels = float((2 * kRadius + 1) * (2 * kRadius + 1));
constexpr float kFlat =
    0.02f * kWindowPixels;  // sum of squares below which a window is without texture [grey values^2]

void WindowStatisticsOf(const float* region, WindowStatistics& s) {
  window_sums([&](auto n, int i) { return hn::LoadU(n, region + i); }, s.mean);
  window_sums(
      [&](auto n, int i) {
        const auto v = hn::LoadU(n, region + i);
        return hn::Mul(v, v);
      },
      s.inverse_deviation);
  const auto part = hn::Set(f, 1 / kWindowPixels);
  for (int i = 0; i < kCellPixels; i += int(hn::Lanes(f))) {
    const VF sum = hn::Load(f, s.mean + i), mean = hn::Mul(sum, part);
    const VF squares = hn::Sub(hn::Load(f, s.inverse_deviation + i), hn::Mul(sum, mean));
    hn::Store(mean, f, s.mean + i);
    const VF inverse = hn::Div(hn::Set(f, 1.0f), hn::Sqrt(squares));
    hn::Store(hn::IfThenElse(hn::Lt(squares, hn::Set(f, kFlat)), hn::Zero(f), inverse), f, s.inverse_deviation + i);
  }
}

void Correlate(const float* reference, const WindowStatistics& of_reference, const float* other, float* correlation) {
  HWY_ALIGN float products[kCellPixels];
  WindowStatistics of_other;
  WindowStatisticsOf(other, of_other);
  window_sums([&](auto n, int i) { return hn::Mul(hn::LoadU(n, reference + i), hn::LoadU(n, other + i)); }, products);
  for (int i = 0; i < kCellPixels; i += int(hn::Lanes(f))) {
    const VF means = hn::Mul(hn::Load(f, of_reference.mean + i), hn::Load(f, of_other.mean + i));
    const VF covariance = hn::Sub(hn::Load(f, products + i), hn::Mul(means, hn::Set(f, kWindowPixels)));
    const VF scale =
        hn::Mul(hn::Load(f, of_reference.inverse_deviation + i), hn::Load(f, of_other.inverse_deviation + i));
    hn::Store(hn::Mul(covariance, scale), f, correlation + i);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {

HWY_EXPORT(SampleBytes);
HWY_EXPORT(SampleFloats);
HWY_EXPORT(Carry);
HWY_EXPORT(Census);
HWY_EXPORT(CensusDistance);
HWY_EXPORT(Add);
HWY_EXPORT(Cost);
HWY_EXPORT(WindowStatisticsOf);
HWY_EXPORT(Correlate);

Quads quads_of(const GreyImage& image) {
  Quads quads{image.width, image.height, {}};
  const std::size_t stride = std::size_t(image.width) + 1;
  quads.data.assign(stride * (std::size_t(image.height) + 1), 0);
  for (int y = 1; y < image.height; ++y) {
    const std::uint8_t* upper = image.row(y - 1);
    const std::uint8_t* lower = image.row(y);
    std::int32_t* out = quads.data.data() + std::size_t(y) * stride;
    for (int x = 1; x < image.width; ++x) {
      const std::uint32_t a = upper[x - 1], b = upper[x], c = lower[x - 1], d = lower[x];
      const bool all = a && b && c && d;
      out[x] = all ? std::int32_t(a | b << 8 | c << 16 | d << 24) : 0;
    }
  }
  return quads;
}

void carry(const Transfer& transfer, int left, int top, const float* w, Carried& carried) {
  HWY_DYNAMIC_DISPATCH(Carry)(transfer, left, top, w, carried);
}
void sample(const Quads& quads, const Carried& carried, float dx, float dy, float dz, std::int8_t* out) {
  HWY_DYNAMIC_DISPATCH(SampleBytes)(quads, carried, dx, dy, dz, out);
}
void sample(const Quads& quads, const Carried& carried, float dx, float dy, float dz, float* out) {
  HWY_DYNAMIC_DISPATCH(SampleFloats)(quads, carried, dx, dy, dz, out);
}
void census(const std::int8_t* region, std::uint8_t* planes) { HWY_DYNAMIC_DISPATCH(Census)(region, planes); }
void census_distance(const std::int8_t* region, const std::uint8_t* planes, std::uint8_t* distance) {
  HWY_DYNAMIC_DISPATCH(CensusDistance)(region, planes, distance);
}
void clear(Smallest& s) {
  std::fill(s.first, s.first + kCellPixels, std::uint8_t(255));
  std::fill(s.second, s.second + kCellPixels, std::uint8_t(255));
  std::fill(s.third, s.third + kCellPixels, std::uint8_t(255));
  std::fill(s.count, s.count + kCellPixels, std::uint8_t(0));
}
void add(const std::uint8_t* distance, Smallest& smallest) { HWY_DYNAMIC_DISPATCH(Add)(distance, smallest); }
void cost(const Smallest& smallest, std::uint8_t* out) { HWY_DYNAMIC_DISPATCH(Cost)(smallest, out); }
void window_statistics(const float* region, WindowStatistics& statistics) {
  HWY_DYNAMIC_DISPATCH(WindowStatisticsOf)(region, statistics);
}
void correlate(const float* reference, const WindowStatistics& of_reference, const float* other, float* correlation) {
  HWY_DYNAMIC_DISPATCH(Correlate)(reference, of_reference, other, correlation);
}

}  // namespace collinea::dense
#endif  // HWY_ONCE
