// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/row_correlation.h"

#include <algorithm>
#include <cmath>

#include "collinea/dense/internal/row_products.h"
#include "collinea/dense/internal/row_sample.h"

namespace collinea {
namespace {

// Parts of a grey value that patterns between pixels hold: sums of products stay within 31 bits.
int units_of(int half) { return half <= 25 ? 8 : 2; }

std::int32_t rounded(float value) { return std::int32_t(value < 0 ? value - 0.5F : value + 0.5F); }

WindowPattern empty_pattern(int half) {
  WindowPattern made;
  const int side = 2 * half + 1;
  made.half = half;
  made.width = (side + dense::kPatternUnit - 1) / dense::kPatternUnit * dense::kPatternUnit;
  made.grey.assign(std::size_t(made.width * side), 0);
  return made;
}

bool says_nothing(const WindowPattern& pattern) { return !(pattern.spread() > 0) || pattern.gradients == 0; }

// Offset of the top of the parabola through three values, within half a pixel, so that rounding leads back.
double top(double before, double at, double behind) {
  const double curvature = before - 2 * at + behind;
  return curvature < 0 ? std::clamp((before - behind) / (2 * curvature), -0.499, 0.499) : 0;
}

// The best of the rows is that whose parabola along its columns reaches highest: of sheared windows that on the right
// row half a column off correlates less than that on the next row, where the shear makes up for it. Nothing when that
// lies at an end of the columns.
std::optional<std::size_t> highest(const std::vector<double>& values, int columns) {
  std::optional<std::size_t> best;
  double best_height = 0;
  for (auto row = values.begin(); row != values.end(); row += columns) {
    const auto at = std::max_element(row, row + columns);
    const bool is_inside = at != row && at + 1 != row + columns;
    const double offset = is_inside ? top(at[-1], at[0], at[1]) : 0;
    const double height = is_inside ? at[0] + 0.25 * offset * (at[1] - at[-1]) : at[0];
    if (best && height <= best_height) continue;
    best = std::size_t(at - values.begin());
    best_height = height;
  }
  const int column = int(*best) % columns;
  if (column == 0 || column == columns - 1) return std::nullopt;
  return best;
}

}  // namespace

void WindowPattern::add(int u, int v, std::int16_t value, std::int32_t slope) {
  grey[std::size_t((v + half) * width + u + half)] = value;
  sum += value;
  squares += std::int32_t(value) * value;
  gradients += std::int64_t(slope) * slope;
  ++count;
}

std::optional<WindowPattern> WindowPattern::of(const GreyImage& image, const Eigen::Vector2i& middle, int half) {
  if (middle.x() < half + 1 || middle.y() < half + 1 || middle.x() + half + 1 >= image.width ||
      middle.y() + half + 1 >= image.height)
    return std::nullopt;
  WindowPattern made = empty_pattern(half);
  for (int v = -half; v <= half; ++v) {
    const std::uint8_t* row = image.row(middle.y() + v) + middle.x();
    for (int u = -half; u <= half; ++u) {
      if (row[u] == 0) return std::nullopt;
      made.add(u, v, row[u], std::int32_t(row[u + 1]) - row[u - 1]);
    }
  }
  if (says_nothing(made)) return std::nullopt;
  return made;
}

std::optional<WindowPattern> WindowPattern::of(const GreyImage& image, const Eigen::Vector2i& middle, int half,
                                               const PatternShape& shape) {
  if (middle.y() < half || middle.y() + half >= image.height) return std::nullopt;
  WindowPattern made = empty_pattern(half);
  const float units = float(units_of(half)), slopes = 2 * units * float(shape.stretch);
  for (int v = -half; v <= half; ++v) {
    const std::uint8_t* row = image.row(middle.y() + v);
    for (int u = -half; u <= half; ++u) {
      const auto found = row_sample(row, image.width, middle.x() + 0.5 + shape.stretch * u + shape.shear * v);
      if (!found) return std::nullopt;
      made.add(u, v, std::int16_t(rounded(units * std::clamp(found->value, 0.0F, 255.0F))),
               rounded(slopes * found->slope));
    }
  }
  if (says_nothing(made)) return std::nullopt;
  return made;
}

SearchedBand::SearchedBand(const GreyImage& image, int half, const SearchBand& band)
    : image_(&image),
      half_(half),
      first_column_(std::max(band.first_column, half)),
      first_row_(std::max(band.first_row, half)),
      columns_(std::min(band.last_column, image.width - 1 - half) - first_column_ + 1),
      rows_(std::min(band.last_row, image.height - 1 - half) - first_row_ + 1) {
  if (is_empty()) return;
  const int side = 2 * half + 1, used = columns_ + side - 1;
  stride_ = used + (side + dense::kPatternUnit - 1) / dense::kPatternUnit * dense::kPatternUnit;
  pixels_.assign(std::size_t(stride_) * std::size_t(rows_ + side - 1), 0);
  for (int y = 0; y < rows_ + side - 1; ++y)
    std::copy_n(image.row(first_row_ - half + y) + (first_column_ - half), used,
                pixels_.begin() + std::ptrdiff_t(y) * stride_);
  sum_windows(side);
}

// By sums down the columns of the windows of a row.
void SearchedBand::sum_windows(int side) {
  const int used = columns_ + side - 1;
  const std::int64_t count = std::int64_t(side) * side;
  sums_.resize(std::size_t(columns_) * std::size_t(rows_));
  by_spread_.resize(sums_.size());
  std::vector<std::int32_t> sums(std::size_t(used), 0), squares(sums);
  for (int y = 0; y < rows_ + side - 1; ++y) {
    const std::uint8_t* entering = pixels_.data() + std::ptrdiff_t(y) * stride_;
    const std::uint8_t* leaving = y >= side ? entering - std::ptrdiff_t(side) * stride_ : nullptr;
    for (int x = 0; x < used; ++x) {
      const std::int32_t in = entering[x], out = leaving ? leaving[x] : 0;
      sums[std::size_t(x)] += in - out;
      squares[std::size_t(x)] += in * in - out * out;
    }
    if (y < side - 1) continue;
    std::int64_t sum = 0, square = 0;
    for (int x = 0; x < used; ++x) {
      sum += sums[std::size_t(x)];
      square += squares[std::size_t(x)];
      if (x < side - 1) continue;
      const std::size_t window = std::size_t(y - side + 1) * std::size_t(columns_) + std::size_t(x - side + 1);
      const std::int64_t spread = count * square - sum * sum;
      sums_[window] = sum;
      by_spread_[window] = spread > 0 ? 1 / std::sqrt(double(spread)) : 0;
      sum -= sums[std::size_t(x - side + 1)];
      square -= squares[std::size_t(x - side + 1)];
    }
  }
}

std::vector<double> SearchedBand::correlations(const WindowPattern& pattern) const {
  const int side = 2 * half_ + 1;
  const double by_pattern = 1 / std::sqrt(pattern.spread());
  std::vector<double> values(sums_.size());
  std::vector<std::int32_t> products(static_cast<std::size_t>(columns_));
  for (int row = 0; row < rows_; ++row) {
    dense::row_products(pattern.grey.data(), pattern.width, side, pixels_.data() + std::ptrdiff_t(row) * stride_,
                        stride_, columns_, products.data());
    for (std::size_t x = 0; x < products.size(); ++x) {
      const std::size_t window = std::size_t(row) * std::size_t(columns_) + x;
      values[window] =
          double(pattern.count * products[x] - sums_[window] * pattern.sum) * by_spread_[window] * by_pattern;
    }
  }
  return values;
}

std::optional<BestCorrelation> SearchedBand::best(const WindowPattern& pattern) const {
  if (is_empty()) return std::nullopt;
  const std::vector<double> values = correlations(pattern);
  const auto window = highest(values, columns_);
  if (!window) return std::nullopt;
  BestCorrelation best;
  best.ncc = values[*window];
  best.pixel = {first_column_ + int(*window) % columns_, first_row_ + int(*window) / columns_};
  best.position_px = best.pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5);
  best.position_px.x() += top(values[*window - 1], best.ncc, values[*window + 1]);
  const SearchedBand across(*image_, half_, {best.pixel.x(), best.pixel.x(), best.pixel.y() - 1, best.pixel.y() + 1});
  if (across.rows_ == 3) {
    const std::vector<double> column = across.correlations(pattern);
    best.position_px.y() += top(column[0], best.ncc, column[2]);
  }
  // Residuals of the grey values by the gradients of the pattern, two pixels apart.
  const double residual2 = (1 - best.ncc * best.ncc) * pattern.spread() / double(pattern.count * (pattern.count - 4));
  best.sigma_px = std::sqrt(std::max(residual2, 0.0) / (double(pattern.gradients) / 4));
  return best;
}

std::optional<BestCorrelation> best_correlation(const GreyImage& image, const Eigen::Vector2i& middle, int half,
                                                const GreyImage& other, const SearchBand& band) {
  const auto pattern = WindowPattern::of(image, middle, half);
  return pattern ? SearchedBand(other, half, band).best(*pattern) : std::nullopt;
}

}  // namespace collinea
