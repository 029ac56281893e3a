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

Plane plane_of(int width, int height, const RowSource& rows) {
  Plane out(width, height);
  for (int y = 0; y < height; ++y) rows(y, out.row(y));
  return out;
}

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

RowFilter::RowFilter(int width, int height, double sigma_px)
    : taps_(gaussian_taps(sigma_px)),
      radius_(static_cast<int>(taps_.size()) - 1),
      width_(width),
      height_(height),
      ring_(width, 2 * radius_ + 1),
      padded_(static_cast<std::size_t>(width + 2 * radius_ + 2 * kRowSlack)),
      rows_(static_cast<std::size_t>(2 * radius_ + 1)) {}

void RowFilter::next(const RowSource& source, float* out) {
  COLLINEA_CHECK(next_ < height_);
  while (filled_ < std::min(height_, next_ + radius_ + 1)) fill(source);
  for (int j = -radius_; j <= radius_; ++j)
    rows_[static_cast<std::size_t>(radius_ + j)] = ring_.row(std::clamp(next_ + j, 0, height_ - 1) % ring_.height());
  filter_across_rows(rows_.data(), width_, taps_.data(), radius_, out);
  ++next_;
}

void RowFilter::fill(const RowSource& source) {
  float* row = padded_.data() + radius_;
  source(filled_, row);
  std::fill(padded_.data(), row, row[0]);
  std::fill(row + width_, row + width_ + radius_, row[width_ - 1]);
  filter_along_row(row, width_, taps_.data(), radius_, ring_.row(filled_ % ring_.height()));
  ++filled_;
}

Plane blurred(const Plane& in, double sigma_px) {
  RowFilter filter(in.width(), in.height(), sigma_px);
  const RowSource source = [&](int y, float* row) { std::copy_n(in.row(y), in.width(), row); };
  return plane_of(in.width(), in.height(), [&](int, float* row) { filter.next(source, row); });
}

Plane first_level(const GreyImage& image, bool upsample) {
  const int times = upsample ? 2 : 1;
  return plane_of(times * image.width, times * image.height, first_level_rows(image, upsample));
}

RowSource first_level_rows(const GreyImage& image, bool upsample) {
  const int times = upsample ? 2 : 1;
  const double blur_px2 = times * times * (kBlurOfPixel_px2 + (upsample ? kBlurOfUpsampling_px2 : 0));
  const auto filter = std::make_shared<RowFilter>(times * image.width, times * image.height,
                                                  std::sqrt(kFirstBlur_px * kFirstBlur_px - blur_px2));
  RowSource source = [&image](int y, float* row) { widen_row(image.row(y), image.width, row); };
  if (upsample)
    source = [&image, near = std::vector<float>(static_cast<std::size_t>(image.width))](int y, float* row) mutable {
      upsampled_row(image, y, near.data(), row);
    };
  return [filter, source](int, float* row) { filter->next(source, row); };
}

}  // namespace collinea
