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

// Rows of a strip of an image filtered along, the border repeated above and below; and their sums across.
class FilteredRows {
 public:
  FilteredRows(const Raster<std::uint8_t>& image, const std::vector<float>& taps, int first, int end)
      : taps_(taps),
        top_(first - int(taps.size()) + 1),
        length_(std::size_t(image.width) * std::size_t(image.channels)),
        rows_(std::size_t(end - first + 2 * (int(taps.size()) - 1)) * length_) {
    std::vector<float> padded;
    const int below = top_ + int(rows_.size() / length_);
    for (int y = top_; y < below; ++y)
      if (y > top_ && (y <= 0 || y >= image.height))
        std::copy_n(row(y - 1), length_, row(y));
      else
        filter_along(image.row(std::clamp(y, 0, image.height - 1)), image.width, image.channels, taps, padded, row(y));
  }
  // Of all columns of a row, added to `start`.
  void sum(int y, float start, std::vector<float>& out) {
    out.resize(length_);
    for (std::size_t i = 0; i < length_; ++i) out[i] = start + taps_[0] * row(y)[i];
    for (std::size_t k = 1; k < taps_.size(); ++k) {
      const float *above = row(y - int(k)), *below = row(y + int(k));
      const float tap = taps_[k];
      for (std::size_t i = 0; i < length_; ++i) out[i] += tap * (above[i] + below[i]);
    }
  }

 private:
  float* row(int y) { return rows_.data() + std::size_t(y - top_) * length_; }

  const std::vector<float>& taps_;
  int top_;
  std::size_t length_;
  std::vector<float> rows_;
};

// The image with zeros where it is empty.
Raster<std::uint8_t> blanked(Raster<std::uint8_t> image, const GreyImage& known) {
  const auto channels = std::size_t(image.channels);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    if (known.data[i / channels] == 0) image.data[i] = 0;
  return image;
}

// The mask with 255 wherever it is not 0.
GreyImage full_mask(GreyImage known) {
  for (std::uint8_t& value : known.data) value = value == 0 ? 0 : 255;
  return known;
}

// What is known, by the weight of what is known.
Raster<std::uint8_t> gaussian_of_known(const Raster<std::uint8_t>& image, const std::vector<float>& taps,
                                       const GreyImage& known, const Run& run) {
  const Raster<std::uint8_t> values = blanked(image, known);
  const GreyImage mask = full_mask(known);
  const auto channels = std::size_t(image.channels);
  Raster<std::uint8_t> out(image.width, image.height, image.channels);
  for_each_strip(run, image.height, [&](int first, int end) {
    FilteredRows of_values(values, taps, first, end), of_mask(mask, taps, first, end);
    std::vector<float> sum, weight;
    for (int y = first; y < end; ++y) {
      of_values.sum(y, 0, sum);
      of_mask.sum(y, 0, weight);
      std::uint8_t* to = out.row(y);
      for (std::size_t i = 0; i < sum.size(); ++i)
        if (mask.row(y)[i / channels] != 0)
          to[i] = static_cast<std::uint8_t>(int(std::min(0.5f + 255 * sum[i] / weight[i / channels], 255.0f)));
    }
  });
  return out;
}

// Numbers, sums of values and of squares of the columns of a window that goes down row by row.
class ColumnSums {
 public:
  ColumnSums(const Raster<std::uint8_t>& image, const GreyImage* known, int radius)
      : image_(image),
        known_(known),
        radius_(radius),
        counts_(std::size_t(image.width)),
        sums_(counts_.size() * std::size_t(image.channels)),
        squares_(sums_.size()) {}

  /// Of the rows y - radius .. y + radius that there are. `y` ascends by one.
  void move_to(int y) {
    const int first = std::max(0, y - radius_), end = std::min(image_.height, y + radius_ + 1);
    if (first_ == end_) first_ = end_ = first;
    while (end_ < end) add(end_++, 1);
    while (first_ < first) add(first_++, ~std::uint32_t{0});
  }
  [[nodiscard]] const std::vector<std::uint32_t>& counts() const { return counts_; }
  [[nodiscard]] const std::vector<std::uint32_t>& sums() const { return sums_; }
  [[nodiscard]] const std::vector<std::uint32_t>& squares() const { return squares_; }

 private:
  // Times 1 or, by overflow, minus 1.
  void add(int y, std::uint32_t times) {
    const std::uint8_t* row = image_.row(y);
    const auto channels = std::size_t(image_.channels);
    for (std::size_t x = 0; x < counts_.size(); ++x) {
      if (known_ && known_->row(y)[x] == 0) continue;
      counts_[x] += times;
      for (std::size_t i = x * channels; i < (x + 1) * channels; ++i) {
        const std::uint32_t value = row[i];
        sums_[i] += times * value;
        squares_[i] += times * value * value;
      }
    }
  }

  const Raster<std::uint8_t>& image_;
  const GreyImage* known_;
  int radius_, first_ = 0, end_ = 0;
  std::vector<std::uint32_t> counts_, sums_, squares_;  // at most 2001 rows: below 2^31
};

std::uint8_t wallis_grey(double grey, std::int64_t n, std::int64_t sum, std::int64_t squares, const WallisOptions& o) {
  const double mean = double(sum) / double(n);
  const double s = std::sqrt(double(n * squares - sum * sum)) / double(n);
  const double scale = o.contrast_share * s + (1 - o.contrast_share) * o.contrast_grey;
  const double factor = s > 0 ? o.contrast_share * o.contrast_grey / scale : 0;
  const double wished = factor * (grey - mean) + o.mean_share * o.mean_grey + (1 - o.mean_share) * mean;
  return static_cast<std::uint8_t>(std::clamp(wished + 0.5, 0.0, 255.0));
}

void wallis_row(const ColumnSums& columns, const Raster<std::uint8_t>& image, const GreyImage* known, int y, int radius,
                const WallisOptions& o, std::uint8_t* out) {
  const auto channels = std::size_t(image.channels);
  for (std::size_t c = 0; c < channels; ++c) {
    std::int64_t n = 0, sum = 0, squares = 0;
    const auto add = [&](int x, std::int64_t times) {
      n += times * columns.counts()[std::size_t(x)];
      sum += times * columns.sums()[std::size_t(x) * channels + c];
      squares += times * columns.squares()[std::size_t(x) * channels + c];
    };
    for (int x = 0; x < std::min(radius, image.width); ++x) add(x, 1);
    for (int x = 0; x < image.width; ++x) {
      if (x + radius < image.width) add(x + radius, 1);
      if (x - radius > 0) add(x - radius - 1, -1);
      if (known && known->at(x, y) == 0) continue;
      out[std::size_t(x) * channels + c] = wallis_grey(image.at(x, y, int(c)), n, sum, squares, o);
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

Raster<std::uint8_t> gaussian_filtered(const Raster<std::uint8_t>& image, double sigma_px, const Run& run,
                                       const GreyImage* known) {
  if (image.empty() || !(sigma_px > 0)) return image;
  const std::vector<float> taps = gaussian_taps(sigma_px);
  if (known) return gaussian_of_known(image, taps, *known, run);
  Raster<std::uint8_t> out(image.width, image.height, image.channels);
  for_each_strip(run, image.height, [&](int first, int end) {
    FilteredRows rows(image, taps, first, end);
    std::vector<float> sum;
    for (int y = first; y < end; ++y) {
      rows.sum(y, 0.5f, sum);
      std::uint8_t* to = out.row(y);
      for (std::size_t i = 0; i < sum.size(); ++i) to[i] = static_cast<std::uint8_t>(int(std::min(sum[i], 255.0f)));
    }
  });
  return out;
}

Raster<std::uint8_t> wallis_filtered(const Raster<std::uint8_t>& image, const WallisOptions& options, const Run& run,
                                     const GreyImage* known) {
  if (image.empty()) return image;
  const int radius = options.window_px / 2;
  Raster<std::uint8_t> out(image.width, image.height, image.channels);
  for_each_strip(run, image.height, [&](int first, int end) {
    ColumnSums columns(image, known, radius);
    for (int y = first; y < end; ++y) {
      columns.move_to(y);
      wallis_row(columns, image, known, y, radius, options, out.row(y));
    }
  });
  return out;
}

}  // namespace collinea
