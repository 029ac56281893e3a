// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/row_correlation.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "collinea/dense/internal/row_products.h"

namespace collinea {
namespace {

struct Template {
  std::vector<std::int16_t> grey;  // rows of `width`; whole numbers: the same bits everywhere
  int width = 0;
  std::int64_t sum = 0, squares = 0, gradients = 0;
  std::int64_t count = 0;

  [[nodiscard]] double spread() const { return double(count * squares - sum * sum); }
};

std::optional<Template> template_of(const GreyImage& image, const Eigen::Vector2i& middle, int half) {
  if (middle.x() < half + 1 || middle.y() < half + 1 || middle.x() + half + 1 >= image.width ||
      middle.y() + half + 1 >= image.height)
    return std::nullopt;
  Template made;
  const int side = 2 * half + 1;
  made.width = (side + dense::kPatternUnit - 1) / dense::kPatternUnit * dense::kPatternUnit;
  made.grey.assign(std::size_t(made.width * side), 0);
  for (int v = 0; v < side; ++v) {
    const int y = middle.y() - half + v, left = middle.x() - half;
    for (int u = 0; u < side; ++u) {
      const std::int32_t grey = image.at(left + u, y);
      if (grey == 0) return std::nullopt;
      const std::int32_t slope = std::int32_t(image.at(left + u + 1, y)) - image.at(left + u - 1, y);
      made.grey[std::size_t(v * made.width + u)] = std::int16_t(grey);
      made.sum += grey;
      made.squares += grey * grey;
      made.gradients += slope * slope;
      ++made.count;
    }
  }
  if (!(made.spread() > 0) || made.gradients == 0) return std::nullopt;
  return made;
}

// Correlations of a template with the windows of a band, which all lie in the image.
class BandCorrelations {
 public:
  BandCorrelations(const Template& pattern, const GreyImage& image, int half, const SearchBand& band)
      : first_column_(band.first_column),
        first_row_(band.first_row),
        columns_(band.last_column - band.first_column + 1) {
    const int rows = band.last_row - band.first_row + 1, side = 2 * half + 1;
    const int pixels = columns_ + side - 1, stride = pixels + pattern.width;
    std::vector<std::uint8_t> searched(std::size_t(stride) * std::size_t(rows + side - 1), 0);
    for (int y = 0; y < rows + side - 1; ++y)
      std::copy_n(image.row(first_row_ - half + y) + (first_column_ - half), pixels,
                  searched.begin() + std::ptrdiff_t(y) * stride);
    values_.resize(std::size_t(columns_ * rows));
    std::vector<std::int32_t> products(static_cast<std::size_t>(columns_)), sums(std::size_t(pixels), 0), squares(sums);
    for (int y = 0; y < rows + side - 1; ++y) {
      const std::uint8_t* entering = searched.data() + std::ptrdiff_t(y) * stride;
      const std::uint8_t* leaving = y >= side ? entering - std::ptrdiff_t(side) * stride : nullptr;
      for (std::size_t x = 0; x < sums.size(); ++x) {
        sums[x] += entering[x] - (leaving ? leaving[x] : 0);
        squares[x] += entering[x] * entering[x] - (leaving ? leaving[x] * leaving[x] : 0);
      }
      if (y < side - 1) continue;
      dense::row_products(pattern.grey.data(), pattern.width, side,
                          searched.data() + std::ptrdiff_t(y - side + 1) * stride, stride, columns_, products.data());
      correlate(pattern, side, products, sums, squares, y - side + 1);
    }
  }

  [[nodiscard]] double at(int column, int row) const {
    return values_[std::size_t((row - first_row_) * columns_ + column - first_column_)];
  }

 private:
  // A row, of sums down the columns of its windows.
  void correlate(const Template& pattern, int side, const std::vector<std::int32_t>& products,
                 const std::vector<std::int32_t>& sums, const std::vector<std::int32_t>& squares, int row) {
    std::int64_t sum = 0, square = 0;
    for (int x = 0; x < side - 1; ++x) {
      sum += sums[std::size_t(x)];
      square += squares[std::size_t(x)];
    }
    for (int x = 0; x < columns_; ++x) {
      const std::size_t entering = std::size_t(x + side - 1), leaving = std::size_t(x);
      sum += sums[entering];
      square += squares[entering];
      const double spread = double(pattern.count * square - sum * sum);
      values_[std::size_t(row * columns_ + x)] =
          spread > 0
              ? double(pattern.count * products[leaving] - sum * pattern.sum) / std::sqrt(spread * pattern.spread())
              : 0;
      sum -= sums[leaving];
      square -= squares[leaving];
    }
  }

  int first_column_, first_row_, columns_;
  std::vector<double> values_;
};

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
  const BandCorrelations correlations(*pattern, other, half, {first_column, last_column, first_row, last_row});
  for (int row = first_row; row <= last_row; ++row)
    for (int column = first_column; column <= last_column; ++column)
      if (const double ncc = correlations.at(column, row); ncc > best.ncc) {
        best.ncc = ncc;
        best.pixel = {column, row};
      }
  const auto [column, row] = std::pair(best.pixel.x(), best.pixel.y());
  if (column == first_column || column == last_column) return std::nullopt;
  best.position_px = best.pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5);
  best.position_px.x() += top(correlations.at(column - 1, row), best.ncc, correlations.at(column + 1, row));
  if (row > half && row < other.height - 1 - half) {
    const BandCorrelations across(*pattern, other, half, {column, column, row - 1, row + 1});
    best.position_px.y() += top(across.at(column, row - 1), best.ncc, across.at(column, row + 1));
  }
  // Residuals of the grey values by the gradients of the template, two pixels apart.
  const double residual2 =
      (1 - best.ncc * best.ncc) * pattern->spread() / double(pattern->count * (pattern->count - 4));
  best.sigma_px = std::sqrt(std::max(residual2, 0.0) / (double(pattern->gradients) / 4));
  return best;
}

}  // namespace collinea
