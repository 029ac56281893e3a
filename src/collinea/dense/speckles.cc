// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

#include "collinea/dense/internal/level.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collinea/dense/speckles.cc"
#include <hwy/foreach_target.h>
//
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace collinea::dense {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Bit i of `joined`: values a[i] and b[i] differ by at most `reach` and twice both standard deviations, where there are
// any. NaN differ from everything.
void Joined(const float* a, const float* b, const float* sigma_a, const float* sigma_b, float reach, int count,
            std::uint64_t* HWY_RESTRICT joined) {
  const hn::CappedTag<float, 16> f;
  const int lanes = int(hn::Lanes(f));
  std::fill_n(joined, (count + 63) / 64, std::uint64_t(0));
  int i = 0;
  for (; i + lanes <= count; i += lanes) {
    auto limit = hn::Set(f, reach);
    if (sigma_a) {
      const auto both = hn::Add(hn::LoadU(f, sigma_a + i), hn::LoadU(f, sigma_b + i));
      limit = hn::Add(limit, hn::Add(both, both));
    }
    const auto apart = hn::Abs(hn::Sub(hn::LoadU(f, a + i), hn::LoadU(f, b + i)));
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(f, hn::Le(apart, limit), bytes);
    joined[i / 64] |= std::uint64_t(bytes[0] | bytes[1] << 8) << (i % 64);
  }
  for (; i < count; ++i) {
    const float more = sigma_a ? 2 * (sigma_a[i] + sigma_b[i]) : 0;
    if (std::abs(a[i] - b[i]) <= reach + more) joined[i / 64] |= std::uint64_t(1) << (i % 64);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace collinea::dense
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace collinea::dense {
namespace {

HWY_EXPORT(Joined);

// A bit for each pixel of a row.
using Bits = std::vector<std::uint64_t>;

// Runs of pixels that belong together along rows, joined across rows to patches. Every run points to one of its patch
// before it, the first of the patch to itself.
class Patches {
 public:
  Patches(const FloatImage& surface, float reach, const FloatImage* sigma)
      : surface_(surface), reach_(reach), sigma_(sigma) {
    const std::size_t words = std::size_t(surface.width + 63) / 64;
    for (Bits* bits : {&here_.goes_on, &here_.starts, &above_.goes_on, &above_.starts, &joined_})
      bits->assign(words, 0);
    for (int y = 0; y < surface.height; ++y) take_row(y);
    first_.push_back(std::uint32_t(surface.data.size()));
  }

  void empty_smaller_than(int pixels, FloatImage& surface) {
    std::vector<std::uint32_t> size(patch_.size(), 0);
    for (std::size_t run = 0; run < patch_.size(); ++run)  // what is before it points to the first already
      size[patch_[run] = patch_[patch_[run]]] += first_[run + 1] - first_[run];
    for (std::size_t run = 0; run < patch_.size(); ++run)
      if (std::int64_t(size[patch_[run]]) < pixels)
        std::fill(surface.data.begin() + first_[run], surface.data.begin() + first_[run + 1],
                  std::numeric_limits<float>::quiet_NaN());
  }

 private:
  struct Row {
    Bits goes_on;  // to the next pixel
    Bits starts;   // a run
    std::uint32_t first_run = 0;
  };

  void join(const float* a, const float* b, int count, Bits& joined) const {
    const float* sigma = sigma_ ? sigma_->data.data() : nullptr;
    const float* data = surface_.data.data();
    HWY_DYNAMIC_DISPATCH(Joined)
    (a, b, sigma ? sigma + (a - data) : nullptr, sigma ? sigma + (b - data) : nullptr, reach_, count, joined.data());
  }

  void take_row(int y) {
    const int width = surface_.width;
    const float* row = surface_.row(y);
    std::swap(here_, above_);
    join(row, row + 1, width - 1, here_.goes_on);
    if (y > 0) join(row, row - width, width, joined_);
    here_.first_run = std::uint32_t(patch_.size());
    std::uint32_t run_here = here_.first_run - 1, run_above = above_.first_run - 1;
    std::uint64_t before = 0, joined_before = 0;  // the last bits of the words before
    for (std::size_t word = 0; word < joined_.size(); ++word) {
      const std::uint64_t there =
          width - int(word) * 64 >= 64 ? ~std::uint64_t(0) : (std::uint64_t(1) << width % 64) - 1;
      const std::uint64_t starts = here_.starts[word] = ~(here_.goes_on[word] << 1 | before) & there;
      // where two runs meet for the first time, as far as their next pixels tell
      const std::uint64_t still = joined_[word] & here_.goes_on[word] & above_.goes_on[word];
      const std::uint64_t meets = joined_[word] & ~(still << 1 | joined_before);
      before = here_.goes_on[word] >> 63;
      joined_before = still >> 63;
      for (std::uint64_t bits_left = starts | above_.starts[word] | meets; bits_left; bits_left &= bits_left - 1) {
        const std::uint64_t bit = bits_left & -bits_left;
        if (starts & bit) {
          ++run_here;
          first_.push_back(std::uint32_t(std::size_t(y) * std::size_t(width) + 64 * word) +
                           std::uint32_t(std::countr_zero(bit)));
          patch_.push_back(run_here);
        }
        if (above_.starts[word] & bit) ++run_above;
        if (meets & bit) unite(run_here, run_above);
      }
    }
  }

  std::uint32_t first_of(std::uint32_t run) {
    while (patch_[run] != run) run = patch_[run] = patch_[patch_[run]];
    return run;
  }
  void unite(std::uint32_t a, std::uint32_t b) {
    if (patch_[a] == patch_[b]) return;
    a = first_of(a), b = first_of(b);
    patch_[std::max(a, b)] = std::min(a, b);
  }

  const FloatImage& surface_;
  float reach_;
  const FloatImage* sigma_;
  Row here_, above_;
  Bits joined_;                               // each pixel with that above it
  std::vector<std::uint32_t> first_, patch_;  // by run: its first pixel, a run of its patch
};

}  // namespace

void remove_speckles(FloatImage& surface, float reach, int min_pixels, const FloatImage* sigma) {
  if (!surface.empty()) Patches(surface, reach, sigma).empty_smaller_than(min_pixels, surface);
}

}  // namespace collinea::dense
#endif  // HWY_ONCE
