// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/cubic_row.h"

#include <limits>

#include "collinea/raster/cubic.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/raster/cubic_row.cc"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F = hn::ScalableTag<float>;
using I = hn::ScalableTag<std::int32_t>;
using VF = hn::Vec<F>;
using VI = hn::Vec<I>;

// Positions whose sixteen samples all lie in the image.
struct Cells {
  VI column, row;   // of the first of the samples
  VI across, down;  // four floats of a table of weights each, in bytes
};

// False where a position is too near the border, or none.
HWY_INLINE bool cells_of(const Raster<std::uint8_t>& image, const float* xs, const float* ys, Cells& cells) {
  const F f;
  const I i;
  const VF x = hn::LoadU(f, xs), y = hn::LoadU(f, ys), one = hn::Set(f, 1.0f);
  const auto fits = [&](VF at, int size) {
    return hn::And(hn::Ge(at, one), hn::Lt(at, hn::Set(f, float(size) - 2.0f)));
  };
  if (!hn::AllTrue(f, hn::And(fits(x, image.width), fits(y, image.height)))) return false;
  const VF x0 = hn::Floor(x), y0 = hn::Floor(y);
  const auto weights = [&](VF at, VF whole) {
    const VF phase = hn::Add(hn::Mul(hn::Sub(at, whole), hn::Set(f, 256.0f)), hn::Set(f, 0.5f));
    return hn::ShiftLeft<4>(hn::ConvertTo(i, phase));
  };
  cells = {hn::Sub(hn::ConvertTo(i, x0), hn::Set(i, 1)), hn::Sub(hn::ConvertTo(i, y0), hn::Set(i, 1)), weights(x, x0),
           weights(y, y0)};
  return true;
}

template <int kByte>
HWY_INLINE VF byte_of(VI four) {
  const I i;
  return hn::ConvertTo(F(), hn::And(hn::ShiftRight<8 * kByte>(four), hn::Set(i, 255)));
}

struct Weights {
  VF w[4];

  HWY_INLINE explicit Weights(const float* table, VI at) {
    const F f;
    for (int k = 0; k < 4; ++k) w[k] = hn::GatherOffset(f, table + k, at);
  }
  HWY_INLINE VF of(VF a, VF b, VF c, VF d) const {
    return hn::Add(hn::Add(hn::Add(hn::Mul(w[0], a), hn::Mul(w[1], b)), hn::Mul(w[2], c)), hn::Mul(w[3], d));
  }
};

HWY_INLINE VI grey_of(VF sum) {
  const I i;
  const VI rounded = hn::ConvertTo(i, hn::Add(sum, hn::Set(F(), 0.5f)));
  return hn::Min(hn::Max(rounded, hn::Set(i, 1)), hn::Set(i, 255));
}

HWY_INLINE void store(VI values, std::uint8_t* out, int step) {
  HWY_ALIGN std::int32_t lanes[HWY_MAX_BYTES / 4];
  const I i;
  hn::Store(values, i, lanes);
  for (std::size_t k = 0; k < hn::Lanes(i); ++k) out[k * std::size_t(step)] = std::uint8_t(lanes[k]);
}

// Four bytes at a byte offset of each row.
HWY_INLINE VI bytes_at(const std::uint8_t* data, VI offset) {
  return hn::GatherOffset(I(), reinterpret_cast<const std::int32_t*>(data), offset);
}

HWY_INLINE void grey_cells(const Raster<std::uint8_t>& image, const Cells& cells, const float* table,
                           std::uint8_t* out) {
  const I i;
  const Weights across(table, cells.across), down(table, cells.down);
  const VI stride = hn::Set(i, image.width);
  VI at = hn::Add(hn::Mul(cells.row, stride), cells.column);
  VF sum = hn::Zero(F());
  for (int j = 0; j < 4; ++j, at = hn::Add(at, stride)) {
    const VI four = bytes_at(image.data.data(), at);
    sum = hn::Add(
        sum, hn::Mul(down.w[j], across.of(byte_of<0>(four), byte_of<1>(four), byte_of<2>(four), byte_of<3>(four))));
  }
  store(grey_of(sum), out, 1);
}

// The twelve bytes of four pixels: r g b r, g b r g, b r g b.
HWY_INLINE void colour_cells(const Raster<std::uint8_t>& image, const Cells& cells, const float* table,
                             std::uint8_t* out) {
  const I i;
  const Weights across(table, cells.across), down(table, cells.down);
  const VI stride = hn::Set(i, 3 * image.width);
  VI at = hn::Add(hn::Mul(cells.row, stride), hn::Mul(cells.column, hn::Set(i, 3)));
  VF red = hn::Zero(F()), green = red, blue = red;
  for (int j = 0; j < 4; ++j, at = hn::Add(at, stride)) {
    const VI a = bytes_at(image.data.data(), at), b = bytes_at(image.data.data() + 4, at),
             c = bytes_at(image.data.data() + 8, at);
    red = hn::Add(red, hn::Mul(down.w[j], across.of(byte_of<0>(a), byte_of<3>(a), byte_of<2>(b), byte_of<1>(c))));
    green = hn::Add(green, hn::Mul(down.w[j], across.of(byte_of<1>(a), byte_of<0>(b), byte_of<3>(b), byte_of<2>(c))));
    blue = hn::Add(blue, hn::Mul(down.w[j], across.of(byte_of<2>(a), byte_of<1>(b), byte_of<0>(c), byte_of<3>(c))));
  }
  store(grey_of(red), out, 3);
  store(grey_of(green), out + 1, 3);
  store(grey_of(blue), out + 2, 3);
}

// Returns how many pixels are done; stops before one that is to be read by itself.
int CubicCells(const Raster<std::uint8_t>& image, const float* x, const float* y, int count, const float* table,
               std::uint8_t* out) {
  const int lanes = int(hn::Lanes(F()));
  int done = 0;
  Cells cells;
  for (; done + lanes <= count && cells_of(image, x + done, y + done, cells); done += lanes) {
    if (image.channels == 1)
      grey_cells(image, cells, table, out + done);
    else
      colour_cells(image, cells, table, out + 3 * done);
  }
  return done;
}

}  // namespace collinea::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea {

HWY_EXPORT(CubicCells);

namespace {

constexpr int kAtOnce = 16;  // read one by one, where not all can be read together

template <int kChannels>
void one_by_one(const Raster<std::uint8_t>& image, const float* x, const float* y, int count, std::uint8_t* out) {
  for (int i = 0; i < count; ++i)
    for (int c = 0; c < kChannels; ++c) *out++ = cubic<kChannels>(image, x[i], y[i], c);
}

}  // namespace

void cubic_row(const Raster<std::uint8_t>& image, const float* x, const float* y, int count, std::uint8_t* out) {
  static const auto kWeights = cubic_weights();
  // Offsets of bytes are whole numbers of 32 bits.
  const bool is_small = image.data.size() < std::size_t(std::numeric_limits<std::int32_t>::max());
  for (int done = 0; done < count;) {
    std::uint8_t* const to = out + std::ptrdiff_t(done) * image.channels;
    const int together =
        is_small ? HWY_DYNAMIC_DISPATCH(CubicCells)(image, x + done, y + done, count - done, kWeights[0].data(), to)
                 : 0;
    done += together;
    const int rest = std::min(kAtOnce, count - done);
    (image.channels == 1 ? one_by_one<1> : one_by_one<3>)(image, x + done, y + done, rest,
                                                          to + std::ptrdiff_t(together) * image.channels);
    done += rest;
  }
}

}  // namespace collinea
#endif
