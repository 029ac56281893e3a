// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/local_filters.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "collinea/base/parallel.h"

namespace collinea {
namespace {

constexpr int kStripRows = 128;

void for_each_strip(const Run& run, int height, const std::function<void(int first, int end)>& work) {
  parallel_for(run, std::size_t((height + kStripRows - 1) / kStripRows), [&](std::size_t strip) {
    const int first = int(strip) * kStripRows;
    work(first, std::min(height, first + kStripRows));
  });
}

// One row of bytes filtered along; `padded` has room for the border that is repeated on either side.
void filter_along(const std::uint8_t* in, int width, int channels, const std::vector<float>& taps,
                  std::vector<float>& padded, float* out) {
  const std::size_t radius = taps.size() - 1, step = std::size_t(channels), length = std::size_t(width) * step;
  padded.resize(length + 2 * radius * step);
  for (std::size_t i = 0; i < radius * step; ++i) {
    padded[i] = float(in[i % step]);
    padded[radius * step + length + i] = float(in[length - step + i % step]);
  }
  for (std::size_t i = 0; i < length; ++i) padded[radius * step + i] = float(in[i]);
  const float* middle = padded.data() + radius * step;
  for (std::size_t i = 0; i < length; ++i) out[i] = taps[0] * middle[i];
  for (std::size_t k = 1; k <= radius; ++k) {
    const float *left = middle - k * step, *right = middle + k * step;
    const float tap = taps[k];
    for (std::size_t i = 0; i < length; ++i) out[i] += tap * (left[i] + right[i]);
  }
}

// Sums of values and squares of the columns of a window that goes down row by row.
class ColumnSums {
 public:
  ColumnSums(const Raster<std::uint8_t>& image, int radius)
      : image_(image),
        radius_(radius),
        sums_(std::size_t(image.width) * std::size_t(image.channels)),
        squares_(sums_.size()) {}

  /// Of the rows y - radius .. y + radius that there are; how many. `y` ascends by one.
  int move_to(int y) {
    const int first = std::max(0, y - radius_), end = std::min(image_.height, y + radius_ + 1);
    if (first_ == end_) first_ = end_ = first;
    while (end_ < end) add(end_++, 1);
    while (first_ < first) add(first_++, ~std::uint32_t{0});
    return end - first;
  }
  [[nodiscard]] const std::vector<std::uint32_t>& sums() const { return sums_; }
  [[nodiscard]] const std::vector<std::uint32_t>& squares() const { return squares_; }

 private:
  // Times 1 or, by overflow, minus 1.
  void add(int y, std::uint32_t times) {
    const std::uint8_t* row = image_.row(y);
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const std::uint32_t value = row[i];
      sums_[i] += times * value;
      squares_[i] += times * value * value;
    }
  }

  const Raster<std::uint8_t>& image_;
  int radius_, first_ = 0, end_ = 0;
  std::vector<std::uint32_t> sums_, squares_;  // at most 2001 rows: below 2^31
};

void wallis_row(const ColumnSums& columns, int rows, const Raster<std::uint8_t>& image, int y, int radius,
                const WallisOptions& o, std::uint8_t* out) {
  const auto channels = std::size_t(image.channels);
  const auto at = [&](const std::vector<std::uint32_t>& sums, int x, std::size_t c) {
    return std::int64_t(sums[std::size_t(x) * channels + c]);
  };
  for (std::size_t c = 0; c < channels; ++c) {
    std::int64_t sum = 0, squares = 0;
    for (int x = 0; x < std::min(radius, image.width); ++x) {
      sum += at(columns.sums(), x, c);
      squares += at(columns.squares(), x, c);
    }
    for (int x = 0; x < image.width; ++x) {
      if (x + radius < image.width) {
        sum += at(columns.sums(), x + radius, c);
        squares += at(columns.squares(), x + radius, c);
      }
      if (x - radius > 0) {
        sum -= at(columns.sums(), x - radius - 1, c);
        squares -= at(columns.squares(), x - radius - 1, c);
      }
      const std::int64_t n = std::int64_t(rows) * (std::min(image.width, x + radius + 1) - std::max(0, x - radius));
      const double mean = double(sum) / double(n);
      const double s = std::sqrt(double(n * squares - sum * sum)) / double(n);
      const double scale = o.contrast_share * s + (1 - o.contrast_share) * o.contrast_grey;
      const double factor = s > 0 ? o.contrast_share * o.contrast_grey / scale : 0;
      const double grey =
          factor * (image.at(x, y, int(c)) - mean) + o.mean_share * o.mean_grey + (1 - o.mean_share) * mean;
      out[std::size_t(x) * channels + c] = static_cast<std::uint8_t>(std::clamp(grey + 0.5, 0.0, 255.0));
    }
  }
}

}  // namespace

std::vector<float> gaussian_taps(double sigma_px) {
  const int radius = std::max(1, static_cast<int>(std::ceil(4 * sigma_px)));
  std::vector<double> values(static_cast<std::size_t>(radius) + 1);
  double sum = 0;
  for (int j = 0; j <= radius; ++j) {
    values[static_cast<std::size_t>(j)] = std::exp(-0.5 * j * j / (sigma_px * sigma_px));
    sum += (j == 0 ? 1 : 2) * values[static_cast<std::size_t>(j)];
  }
  std::vector<float> taps;
  for (const double value : values) taps.push_back(static_cast<float>(value / sum));
  return taps;
}

Raster<std::uint8_t> gaussian_filtered(const Raster<std::uint8_t>& image, double sigma_px, const Run& run) {
  if (image.empty() || !(sigma_px > 0)) return image;
  const std::vector<float> taps = gaussian_taps(sigma_px);
  const int radius = int(taps.size()) - 1;
  const std::size_t length = std::size_t(image.width) * std::size_t(image.channels);
  Raster<std::uint8_t> out(image.width, image.height, image.channels);
  for_each_strip(run, image.height, [&](int first, int end) {
    const int top = first - radius, count = end - first + 2 * radius;
    std::vector<float> padded, sum(length), rows(std::size_t(count) * length);
    const auto row = [&](int y) { return rows.data() + std::size_t(y - top) * length; };
    for (int y = top; y < top + count; ++y)
      if (y > top && (y <= 0 || y >= image.height))
        std::copy_n(row(y - 1), length, row(y));
      else
        filter_along(image.row(std::clamp(y, 0, image.height - 1)), image.width, image.channels, taps, padded, row(y));
    for (int y = first; y < end; ++y) {
      for (std::size_t i = 0; i < length; ++i) sum[i] = 0.5f + taps[0] * row(y)[i];
      for (int k = 1; k <= radius; ++k) {
        const float *above = row(y - k), *below = row(y + k);
        const float tap = taps[std::size_t(k)];
        for (std::size_t i = 0; i < length; ++i) sum[i] += tap * (above[i] + below[i]);
      }
      std::uint8_t* to = out.row(y);
      for (std::size_t i = 0; i < length; ++i) to[i] = static_cast<std::uint8_t>(int(std::min(sum[i], 255.0f)));
    }
  });
  return out;
}

Raster<std::uint8_t> wallis_filtered(const Raster<std::uint8_t>& image, const WallisOptions& options, const Run& run) {
  if (image.empty()) return image;
  const int radius = options.window_px / 2;
  Raster<std::uint8_t> out(image.width, image.height, image.channels);
  for_each_strip(run, image.height, [&](int first, int end) {
    ColumnSums columns(image, radius);
    for (int y = first; y < end; ++y) {
      const int rows = columns.move_to(y);
      wallis_row(columns, rows, image, y, radius, options, out.row(y));
    }
  });
  return out;
}

}  // namespace collinea
