// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/texture.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/internal/texture.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The sum of two differences.
void TextureRow(const std::uint8_t* here, const std::uint8_t* below, int width, std::uint8_t* HWY_RESTRICT texture) {
  const hn::CappedTag<std::uint8_t, 64> d;
  for (int x = 0; x < width; x += int(hn::Lanes(d))) {
    const auto own = hn::LoadU(d, here + x);
    const auto apart = [&](const std::uint8_t* from) {
      const auto other = hn::LoadU(d, from + x);
      return hn::Or(hn::SaturatedSub(own, other), hn::SaturatedSub(other, own));
    };
    hn::StoreU(hn::SaturatedAdd(apart(here + 1), apart(below)), d, texture + x);
  }
}

// Sums down the columns of the windows when a row enters and another leaves.
void SlideColumns(const std::uint8_t* entering, const std::uint8_t* leaving, int width,
                  std::uint16_t* HWY_RESTRICT columns) {
  const hn::CappedTag<std::uint16_t, 32> d;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  for (int x = 0; x < width; x += int(hn::Lanes(d))) {
    const auto in = hn::PromoteTo(d, hn::LoadU(d8, entering + x)), out = hn::PromoteTo(d, hn::LoadU(d8, leaving + x));
    hn::StoreU(hn::Sub(hn::Add(hn::LoadU(d, columns + x), in), out), d, columns + x);
  }
}

// `columns` begins kTextureReach before the first pixel.
void MeanRow(const std::uint16_t* columns, const std::uint32_t* parts, int width, std::uint8_t* HWY_RESTRICT mean) {
  const hn::CappedTag<std::uint32_t, 16> d;
  const hn::RebindToSigned<decltype(d)> i;
  const hn::Rebind<std::uint16_t, decltype(d)> d16;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  for (int x = 0; x < width; x += int(hn::Lanes(d))) {
    auto sum = hn::LoadU(d16, columns + x);
    for (int j = 1; j <= 2 * kTextureReach; ++j) sum = hn::Add(sum, hn::LoadU(d16, columns + x + j));
    const auto whole = hn::ShiftRight<kTexturePartBits>(hn::Mul(hn::PromoteTo(d, sum), hn::LoadU(d, parts + x)));
    hn::StoreU(hn::DemoteTo(d8, hn::BitCast(i, whole)), d8, mean + x);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {
namespace {

HWY_EXPORT(TextureRow);
HWY_EXPORT(SlideColumns);
HWY_EXPORT(MeanRow);

constexpr int kSlack = 64;  // what the rows of the kernels may be read and written beyond their ends
constexpr int kSide = 2 * kTextureReach + 1;

// How many of the pixels around `at` there are.
int there(int at, int size) { return std::min(at + kTextureReach, size - 1) - std::max(at - kTextureReach, 0) + 1; }

// One over the number of pixels in a window, so large that sums of bytes times it, rounded down, are their quotients:
// a sum is no more than 255 n, and 255 n^2 < 2^kTexturePartBits for n <= 49.
std::vector<std::uint32_t> parts_of(int width, int rows) {
  static_assert(255 * kSide * kSide * kSide * kSide < 1 << kTexturePartBits);
  std::vector<std::uint32_t> parts(std::size_t(width + kSlack), 0);
  for (int x = 0; x < width; ++x)
    parts[std::size_t(x)] = (1u << kTexturePartBits) / std::uint32_t(there(x, width) * rows) + 1;
  return parts;
}

}  // namespace

GreyImage texture_around(const GreyImage& image) {
  const int width = image.width, height = image.height;
  const std::size_t stride = std::size_t(width + kSlack);
  GreyImage result(width, height);
  if (image.empty()) return result;
  std::vector<std::uint8_t> lines(2 * stride), mean(stride), nothing(stride);
  std::vector<std::uint8_t> textures((kSide + 1) * stride);  // the last rows
  std::vector<std::uint16_t> columns(stride + 2 * kTextureReach);
  std::vector<std::uint32_t> parts;
  int rows_of_parts = 0;
  const auto line = [&](int y) {
    const std::uint8_t* from = image.row(std::min(y, height - 1));
    std::uint8_t* to = lines.data() + std::size_t(y % 2) * stride;
    std::copy_n(from, width, to);
    to[width] = from[width - 1];
    return to;
  };
  const auto texture = [&](int y) { return textures.data() + std::size_t(y % (kSide + 1)) * stride; };
  const std::uint8_t* here = line(0);
  for (int y = 0; y < height + kTextureReach; ++y) {
    if (y < height) {
      const std::uint8_t* below = line(y + 1);
      HWY_DYNAMIC_DISPATCH(TextureRow)(here, below, width, texture(y));
      std::fill_n(texture(y) + width, kSlack, std::uint8_t(0));
      here = below;
    }
    HWY_DYNAMIC_DISPATCH(SlideColumns)
    (y < height ? texture(y) : nothing.data(), y >= kSide ? texture(y - kSide) : nothing.data(), width,
     columns.data() + kTextureReach);
    const int done = y - kTextureReach;
    if (done < 0) continue;
    if (const int rows = there(done, height); rows != rows_of_parts) parts = parts_of(width, rows_of_parts = rows);
    HWY_DYNAMIC_DISPATCH(MeanRow)(columns.data(), parts.data(), width, mean.data());
    std::copy_n(mean.begin(), width, result.row(done));
  }
  return result;
}

}  // namespace collinea::dense
#endif  // HWY_ONCE
