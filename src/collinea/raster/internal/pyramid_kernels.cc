// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/internal/pyramid_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/raster/internal/pyramid_kernels.cc"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
// One lane cannot hold a pair of bytes; the plain loop of HalveRows does it all.
int halve_grey(const std::uint8_t*, const std::uint8_t*, std::uint8_t*, int) { return 0; }
int halve_colour(const std::uint8_t*, const std::uint8_t*, std::uint8_t*, int) { return 0; }
#else
// Means of four bytes: pairs of neighbours are the two bytes of a 16-bit lane.
template <class D8, class V8 = hn::Vec<D8> >
hn::Vec<hn::RepartitionToWide<D8> > mean_of_pairs(D8 /*bytes*/, V8 upper, V8 lower) {
  const hn::RepartitionToWide<D8> words;
  const auto u = hn::BitCast(words, upper), l = hn::BitCast(words, lower);
  const auto low = hn::Set(words, 0xff);
  const auto even = hn::Add(hn::And(u, low), hn::And(l, low));
  const auto odd = hn::Add(hn::ShiftRight<8>(u), hn::ShiftRight<8>(l));
  return hn::ShiftRight<2>(hn::Add(hn::Add(even, odd), hn::Set(words, 2)));
}

int halve_grey(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* out, int count) {
  const hn::ScalableTag<std::uint8_t> bytes;
  const hn::Half<decltype(bytes)> half_bytes;
  const int step = int(hn::Lanes(bytes)) / 2;
  int x = 0;
  for (; x + step <= count; x += step) {
    const auto mean = mean_of_pairs(bytes, hn::LoadU(bytes, upper + 2 * x), hn::LoadU(bytes, lower + 2 * x));
    hn::StoreU(
        hn::DemoteTo(half_bytes, hn::BitCast(hn::RepartitionToWide<hn::RebindToSigned<decltype(bytes)> >(), mean)),
        half_bytes, out + x);
  }
  return x;
}

int halve_colour(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* out, int count) {
  const hn::ScalableTag<std::uint8_t> bytes;
  const hn::Half<decltype(bytes)> half_bytes;
  const hn::RepartitionToWide<hn::RebindToSigned<decltype(bytes)> > signed_words;
  const int step = int(hn::Lanes(bytes)) / 2;
  int x = 0;
  for (; x + step <= count; x += step) {
    hn::Vec<decltype(bytes)> u0, u1, u2, l0, l1, l2;
    hn::LoadInterleaved3(bytes, upper + 6 * x, u0, u1, u2);
    hn::LoadInterleaved3(bytes, lower + 6 * x, l0, l1, l2);
    const auto narrow = [&](auto mean) { return hn::DemoteTo(half_bytes, hn::BitCast(signed_words, mean)); };
    hn::StoreInterleaved3(narrow(mean_of_pairs(bytes, u0, l0)), narrow(mean_of_pairs(bytes, u1, l1)),
                          narrow(mean_of_pairs(bytes, u2, l2)), half_bytes, out + 3 * x);
  }
  return x;
}

#endif

void HalveRows(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* out, int count, int channels) {
  int x = channels == 1 ? halve_grey(upper, lower, out, count) : halve_colour(upper, lower, out, count);
  for (; x < count; ++x)
    for (int c = 0; c < channels; ++c) {
      const int a = 2 * x * channels + c, b = a + channels;
      out[x * channels + c] = std::uint8_t((upper[a] + upper[b] + lower[a] + lower[b] + 2) >> 2);
    }
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(HalveRows);

void halve_rows(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* out, int count, int channels) {
  HWY_DYNAMIC_DISPATCH(HalveRows)(upper, lower, out, count, channels);
}

}  // namespace collinea
#endif
