// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/scale_space.h"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>

#include "collinea/base/result.h"
#include "collinea/raster/local_filters.h"

namespace collinea {
namespace {

// A pixel is the mean over its square. What lens and interpolation of colours add is not known.
constexpr double kBlurOfPixel_px2 = 1.0 / 12;
// Bilinear interpolation half-way between a pixel's centre and its edge spreads by 3/4 * 1/4 pixels squared.
constexpr double kBlurOfUpsampling_px2 = 0.1875;

// Large planes ask for large pages: every octave would else meet thousands of page faults.
float* memory(std::size_t count) {
  constexpr std::size_t kPage = std::size_t{1} << 21;
  const std::size_t bytes = count * sizeof(float);
  const bool large = bytes >= 4 * kPage;
  void* data = large ? std::aligned_alloc(kPage, (bytes + kPage - 1) / kPage * kPage) : std::malloc(bytes);
  if (!data) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE
  if (large) madvise(data, bytes, MADV_HUGEPAGE);  // a wish: it may fail
#endif
  return static_cast<float*>(data);
}

// Rows of an image on their way through the filter along the row, and the last few results for the filter across.
class RowFilter {
 public:
  RowFilter(int width, int height, double sigma_px)
      : taps_(gaussian_taps(sigma_px)),
        radius_(static_cast<int>(taps_.size()) - 1),
        width_(width),
        height_(height),
        ring_(width, 2 * radius_ + 1),
        padded_(static_cast<std::size_t>(width + 2 * radius_ + 2 * kRowSlack)) {}

  /// Calls source(y, float* row) for every row, upper first, and writes the filtered image.
  template <class Source>
  Plane run(const Source& source) {
    Plane out(width_, height_);
    std::vector<const float*> rows(static_cast<std::size_t>(2 * radius_ + 1));
    int filled = 0;
    for (int y = 0; y < height_; ++y) {
      for (; filled < std::min(height_, y + radius_ + 1); ++filled) fill(source, filled);
      for (int j = -radius_; j <= radius_; ++j)
        rows[static_cast<std::size_t>(radius_ + j)] = ring_.row(std::clamp(y + j, 0, height_ - 1) % ring_.height());
      filter_across_rows(rows.data(), width_, taps_.data(), radius_, out.row(y));
    }
    return out;
  }

 private:
  template <class Source>
  void fill(const Source& source, int y) {
    float* row = padded_.data() + radius_;
    source(y, row);
    std::fill(padded_.data(), row, row[0]);
    std::fill(row + width_, row + width_ + radius_, row[width_ - 1]);
    filter_along_row(row, width_, taps_.data(), radius_, ring_.row(y % ring_.height()));
  }

  std::vector<float> taps_;
  int radius_, width_, height_;
  Plane ring_;
  std::vector<float> padded_;
};

// Row y of the image at twice its size: every pixel becomes 2 x 2, interpolated at a quarter of a pixel from its
// centre.
void upsampled_row(const GreyImage& image, int y, float* near, float* out) {
  const int other = std::clamp(y % 2 == 0 ? y / 2 - 1 : y / 2 + 1, 0, image.height - 1);
  const std::uint8_t *a = image.row(y / 2), *b = image.row(other);
  for (int x = 0; x < image.width; ++x) near[x] = 0.75f * a[x] + 0.25f * b[x];
  for (int x = 0; x < image.width; ++x) {
    out[2 * x] = 0.75f * near[x] + 0.25f * near[std::max(0, x - 1)];
    out[2 * x + 1] = 0.75f * near[x] + 0.25f * near[std::min(image.width - 1, x + 1)];
  }
}

}  // namespace

Plane::Plane(int width, int height) : width_(width), height_(height) {
  COLLINEA_CHECK(width > 0 && height > 0);
  stride_ = (width + kRowSlack + 15) / 16 * 16;
  // Rows at multiples of 4096 bytes would compete for the same lines of the cache.
  if (stride_ % 1024 == 0) stride_ += 16;
  data_.reset(memory(static_cast<std::size_t>(stride_) * static_cast<std::size_t>(height)));
}

void Plane::Free::operator()(float* data) const { std::free(data); }

double blur_of_level(double level) { return kFirstBlur_px * std::exp2(level / kSteps); }

Plane blurred(const Plane& in, double sigma_px) {
  return RowFilter(in.width(), in.height(), sigma_px).run([&](int y, float* row) {
    std::copy_n(in.row(y), in.width(), row);
  });
}

Plane first_level(const GreyImage& image, bool upsample) {
  if (!upsample) {
    const double sigma_px = std::sqrt(kFirstBlur_px * kFirstBlur_px - kBlurOfPixel_px2);
    return RowFilter(image.width, image.height, sigma_px).run([&](int y, float* row) {
      widen_row(image.row(y), image.width, row);
    });
  }
  const double blur_px2 = 4 * (kBlurOfPixel_px2 + kBlurOfUpsampling_px2);
  std::vector<float> near(static_cast<std::size_t>(image.width));
  return RowFilter(2 * image.width, 2 * image.height, std::sqrt(kFirstBlur_px * kFirstBlur_px - blur_px2))
      .run([&](int y, float* row) { upsampled_row(image, y, near.data(), row); });
}

Octave octave_from(Plane level0) {
  Octave octave;
  octave[0] = std::move(level0);
  for (int level = 1; level < kLevels; ++level) {
    const double before = blur_of_level(level - 1), after = blur_of_level(level);
    octave[static_cast<std::size_t>(level)] =
        blurred(octave[static_cast<std::size_t>(level) - 1], std::sqrt(after * after - before * before));
  }
  return octave;
}

Plane next_level0(const Octave& octave) {
  const Plane& from = octave[kSteps];
  Plane to((from.width() + 1) / 2, (from.height() + 1) / 2);
  for (int y = 0; y < to.height(); ++y) {
    const float* in = from.row(2 * y);
    float* out = to.row(y);
    for (int x = 0; x < to.width(); ++x) out[x] = in[2 * x];
  }
  return to;
}

}  // namespace collinea
