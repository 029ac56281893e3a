// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/row_correlation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace collinea {
namespace {

// The template without its mean.
struct Template {
  std::vector<std::int32_t> grey;  // whole numbers: the same bits everywhere
  std::int64_t sum = 0, squares = 0, gradients = 0;
  std::int64_t count = 0;

  [[nodiscard]] double spread() const { return double(count * squares - sum * sum); }
};

std::optional<Template> template_of(const GreyImage& image, const Eigen::Vector2i& middle, int half) {
  if (middle.x() < half + 1 || middle.y() < half + 1 || middle.x() + half + 1 >= image.width ||
      middle.y() + half + 1 >= image.height)
    return std::nullopt;
  Template made;
  for (int y = middle.y() - half; y <= middle.y() + half; ++y)
    for (int x = middle.x() - half; x <= middle.x() + half; ++x) {
      const std::int32_t grey = image.at(x, y);
      if (grey == 0) return std::nullopt;
      const std::int32_t slope = std::int32_t(image.at(x + 1, y)) - image.at(x - 1, y);
      made.grey.push_back(grey);
      made.sum += grey;
      made.squares += grey * grey;
      made.gradients += slope * slope;
      ++made.count;
    }
  if (!(made.spread() > 0) || made.gradients == 0) return std::nullopt;
  return made;
}

double correlation_at(const Template& pattern, const GreyImage& image, int column, int row, int half) {
  const int side = 2 * half + 1;
  std::int64_t products = 0, sum = 0, squares = 0;
  const std::int32_t* grey = pattern.grey.data();
  for (int y = row - half; y <= row + half; ++y, grey += side) {
    const std::uint8_t* seen = image.row(y) + (column - half);
    std::int32_t row_products = 0, row_sum = 0, row_squares = 0;
    for (int x = 0; x < side; ++x) {
      row_products += grey[x] * seen[x];
      row_sum += seen[x];
      row_squares += seen[x] * seen[x];
    }
    products += row_products;
    sum += row_sum;
    squares += row_squares;
  }
  const double spread = double(pattern.count * squares - sum * sum);
  return spread > 0 ? double(pattern.count * products - sum * pattern.sum) / std::sqrt(spread * pattern.spread()) : 0;
}

// Offset of the top of the parabola through three values, within half a pixel.
double top(double before, double at, double behind) {
  const double curvature = before - 2 * at + behind;
  return curvature < 0 ? std::clamp((before - behind) / (2 * curvature), -0.5, 0.5) : 0;
}

}  // namespace

std::optional<BestCorrelation> best_correlation(const GreyImage& image, const Eigen::Vector2i& middle, int half,
                                                const GreyImage& other, const SearchBand& band) {
  const auto pattern = template_of(image, middle, half);
  const int first_column = std::max(band.first_column, half),
            last_column = std::min(band.last_column, other.width - 1 - half);
  const int first_row = std::max(band.first_row, half), last_row = std::min(band.last_row, other.height - 1 - half);
  if (!pattern || first_column > last_column || first_row > last_row) return std::nullopt;
  BestCorrelation best;
  best.ncc = -2;
  for (int row = first_row; row <= last_row; ++row)
    for (int column = first_column; column <= last_column; ++column)
      if (const double ncc = correlation_at(*pattern, other, column, row, half); ncc > best.ncc) {
        best.ncc = ncc;
        best.pixel = {column, row};
      }
  const auto [column, row] = std::pair(best.pixel.x(), best.pixel.y());
  if (column == first_column || column == last_column) return std::nullopt;
  const auto at = [&](int x, int y) { return correlation_at(*pattern, other, x, y, half); };
  best.position_px = best.pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5);
  best.position_px.x() += top(at(column - 1, row), best.ncc, at(column + 1, row));
  if (row > half && row < other.height - 1 - half)
    best.position_px.y() += top(at(column, row - 1), best.ncc, at(column, row + 1));
  // Residuals of the grey values by the gradients of the template, two pixels apart.
  const double residual2 =
      (1 - best.ncc * best.ncc) * pattern->spread() / double(pattern->count * (pattern->count - 4));
  best.sigma_px = std::sqrt(std::max(residual2, 0.0) / (double(pattern->gradients) / 4));
  return best;
}

}  // namespace collinea
