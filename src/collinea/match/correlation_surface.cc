// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/correlation_surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "collinea/match/census.h"
#include "collinea/match/internal/area_kernels.h"

namespace collinea {
namespace {

using Eigen::Vector2i;

// A square of the template and the rectangle that is searched, cut out of their images.
struct Cut {
  int size = 0;               // of the template
  int columns = 0, rows = 0;  // of positions; the searched rectangle is larger by size - 1
  GreyImage pattern, searched;
};

GreyImage rectangle(const GreyImage& image, int left, int top, int width, int height) {
  GreyImage out(width, height);
  for (int y = 0; y < height; ++y) std::copy_n(image.row(top + y) + left, width, out.row(y));
  return out;
}

// Sums over the windows of size x size pixels, by running sums of columns; padded as the kernels want it.
template <class Value>
std::vector<std::int32_t> window_sums(const GreyImage& image, int size, int columns, int rows, std::ptrdiff_t stride,
                                      const Value& value) {
  std::vector<std::int32_t> sums(static_cast<std::size_t>(stride * rows + kAreaPadding), 0);
  std::vector<std::int32_t> of_column(static_cast<std::size_t>(image.width), 0);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      auto& sum = of_column[static_cast<std::size_t>(x)];
      sum += value(image.at(x, y));
      if (y >= size) sum -= value(image.at(x, y - size));
    }
    if (y < size - 1) continue;
    std::int32_t sum = 0;
    for (int x = 0; x < size - 1; ++x) sum += of_column[static_cast<std::size_t>(x)];
    std::int32_t* out = sums.data() + stride * (y - size + 1);
    for (int x = 0; x < columns; ++x) {
      sum += of_column[static_cast<std::size_t>(x + size - 1)];
      out[x] = sum;
      sum -= of_column[static_cast<std::size_t>(x)];
    }
  }
  return sums;
}

// Sums of the products of the template with all windows.
std::vector<std::int32_t> products_of(const Cut& cut, std::ptrdiff_t stride) {
  const GreyImage& searched = cut.searched;
  const std::ptrdiff_t pair_stride = searched.width + kAreaPadding;
  std::vector<std::int32_t> pairs(static_cast<std::size_t>(pair_stride * searched.height + kAreaPadding), 0);
  for (int y = 0; y < searched.height; ++y) {
    const std::uint8_t* from = searched.row(y);
    std::int32_t* to = pairs.data() + y * pair_stride;
    for (int x = 0; x + 1 < searched.width; ++x) to[x] = from[x] | from[x + 1] << 16;
    to[searched.width - 1] = from[searched.width - 1];
  }
  const int half_width = (cut.size + 1) / 2;
  std::vector<std::int32_t> halves(static_cast<std::size_t>(half_width * cut.size));
  for (int y = 0; y < cut.size; ++y)
    for (int x = 0; x < cut.size; x += 2)
      halves[static_cast<std::size_t>(y * half_width + x / 2)] =
          cut.pattern.at(x, y) | (x + 1 < cut.size ? cut.pattern.at(x + 1, y) << 16 : 0);
  std::vector<std::int32_t> products(static_cast<std::size_t>(stride * cut.rows + kAreaPadding), 0);
  cross_products(pairs.data(), pair_stride, halves.data(), half_width, cut.size, cut.rows, cut.columns, products.data(),
                 stride);
  return products;
}

std::int32_t square(std::int32_t value) { return value * value; }

void by_products(const Cut& cut, CorrelationSurface& surface) {
  const Similarity method = surface.method;
  const std::ptrdiff_t stride = cut.columns + kAreaPadding;
  const auto products = products_of(cut, stride);
  const auto squares = window_sums(cut.searched, cut.size, cut.columns, cut.rows, stride, square);
  std::int64_t sum = 0, square_sum = 0;
  for (const std::uint8_t grey : cut.pattern.data) {
    sum += grey;
    square_sum += square(grey);
  }
  const double n = square(cut.size);
  FloatImage& out = surface.values = FloatImage(cut.columns, cut.rows);
  if (is_larger_better(method)) {
    surface.deviations = out;
    const bool is_about_mean = method == Similarity::kNcc;  // else about 0, as if all windows had the mean 0
    const auto sums = window_sums(cut.searched, cut.size, cut.columns, cut.rows, stride,
                                  [&](std::int32_t v) { return is_about_mean ? v : 0; });
    if (!is_about_mean) sum = 0;
    const double spread = n * double(square_sum) - double(sum) * double(sum);
    std::vector<float> row(static_cast<std::size_t>(stride)), deviations(row.size());
    for (int y = 0; y < cut.rows; ++y) {
      const std::ptrdiff_t first = y * stride;
      correlations(products.data() + first, sums.data() + first, squares.data() + first, std::size_t(cut.columns), n,
                   double(sum), spread, row.data(), deviations.data());
      std::copy_n(row.data(), cut.columns, out.row(y));
      std::copy_n(deviations.data(), cut.columns, surface.deviations.row(y));
    }
    return;
  }
  for (int y = 0; y < cut.rows; ++y)
    for (int x = 0; x < cut.columns; ++x) {
      const auto i = static_cast<std::size_t>(y * stride + x);
      const auto ssd = double(square_sum - 2 * std::int64_t{products[i]} + squares[i]);
      out.at(x, y) = static_cast<float>(method == Similarity::kSsd ? ssd
                                        : method == Similarity::kD ? std::sqrt(ssd)
                                                                   : std::sqrt(ssd / n));
    }
}

FloatImage by_differences(const Cut& cut) {
  FloatImage out(cut.columns, cut.rows);
  std::vector<std::int32_t> sums(static_cast<std::size_t>(cut.columns));
  std::vector<std::uint16_t> of_row(sums.size());
  for (int y = 0; y < cut.rows; ++y) {
    std::fill(sums.begin(), sums.end(), 0);
    for (int v = 0; v < cut.size; ++v) {
      std::fill(of_row.begin(), of_row.end(), std::uint16_t{0});
      for (int u = 0; u < cut.size; ++u) {  // at most 151 * 255
        const int grey = cut.pattern.at(u, v);
        const std::uint8_t* searched = cut.searched.row(y + v) + u;
        for (std::size_t x = 0; x < of_row.size(); ++x)
          of_row[x] = static_cast<std::uint16_t>(of_row[x] + std::abs(searched[x] - grey));
      }
      for (std::size_t x = 0; x < of_row.size(); ++x) sums[x] += of_row[x];
    }
    std::copy(sums.begin(), sums.end(), out.row(y));
  }
  return out;
}

Raster<std::uint64_t> census_of(const GreyImage& image, int left, int top, int width, int height, int half) {
  Raster<std::uint64_t> out(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) out.at(x, y) = darker_neighbours(image, left + x, top + y, half);
  return out;
}

FloatImage by_census(const Cut& cut, const Raster<std::uint64_t>& pattern, const Raster<std::uint64_t>& searched) {
  FloatImage out(cut.columns, cut.rows);
  for (int y = 0; y < cut.rows; ++y)
    for (int x = 0; x < cut.columns; ++x) {
      int sum = 0;
      for (int v = 0; v < cut.size; ++v)
        for (int u = 0; u < cut.size; ++u) sum += std::popcount(pattern.at(u, v) ^ searched.at(x + u, y + v));
      out.at(x, y) = static_cast<float>(sum);
    }
  return out;
}

GreyImage ranks_of(const Raster<std::uint64_t>& census) {
  GreyImage out(census.width, census.height);
  for (std::size_t i = 0; i < census.data.size(); ++i)
    out.data[i] = static_cast<std::uint8_t>(std::popcount(census.data[i]));
  return out;
}

}  // namespace

CorrelationSurface correlation_surface(const GreyImage& image, const Vector2i& middle, int half, const GreyImage& other,
                                       const Vector2i& expected, int range, Similarity method, int neighbourhood_px) {
  CorrelationSurface surface{.method = method, .pixels = square(2 * half + 1)};
  const int left = std::max(expected.x() - range, half), right = std::min(expected.x() + range, other.width - 1 - half);
  const int top = std::max(expected.y() - range, half),
            bottom = std::min(expected.y() + range, other.height - 1 - half);
  const bool is_inside =
      middle.minCoeff() >= half && middle.x() < image.width - half && middle.y() < image.height - half;
  if (!is_inside || left > right || top > bottom) return surface;
  surface.left = left;
  surface.top = top;
  Cut cut{.size = 2 * half + 1, .columns = right - left + 1, .rows = bottom - top + 1};
  const int from_x = middle.x() - half, from_y = middle.y() - half, width = cut.columns + 2 * half,
            height = cut.rows + 2 * half;
  if (method == Similarity::kRank || method == Similarity::kCensus) {
    const auto pattern = census_of(image, from_x, from_y, cut.size, cut.size, neighbourhood_px / 2);
    const auto searched = census_of(other, left - half, top - half, width, height, neighbourhood_px / 2);
    if (method == Similarity::kCensus) {
      surface.values = by_census(cut, pattern, searched);
    } else {
      cut.pattern = ranks_of(pattern);
      cut.searched = ranks_of(searched);
      surface.values = by_differences(cut);
    }
    return surface;
  }
  cut.pattern = rectangle(image, from_x, from_y, cut.size, cut.size);
  cut.searched = rectangle(other, left - half, top - half, width, height);
  if (method == Similarity::kSad)
    surface.values = by_differences(cut);
  else
    by_products(cut, surface);
  return surface;
}

}  // namespace collinea
