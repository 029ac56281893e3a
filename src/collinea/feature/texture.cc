// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/texture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {
namespace {

// Sum over the window about every pixel, and over how many pixels: by running sums along columns and rows.
FloatImage window_mean(const Raster<double>& values, int side) {
  const int w = values.width, h = values.height, half = side / 2;
  FloatImage out(w, h);
  std::vector<double> column(std::size_t(w), 0);
  const auto add = [&](int y, double sign) {
    if (y >= 0 && y < h)
      for (int x = 0; x < w; ++x) column[std::size_t(x)] += sign * values.at(x, y);
  };
  for (int y = 0; y < half; ++y) add(y, 1);
  for (int y = 0; y < h; ++y) {
    add(y + half, 1);
    add(y - half - 1, -1);
    const int rows = std::min(h - 1, y + half) - std::max(0, y - half) + 1;
    double sum = 0;
    for (int x = 0; x < std::min(half, w); ++x) sum += column[std::size_t(x)];
    for (int x = 0; x < w; ++x) {
      if (x + half < w) sum += column[std::size_t(x + half)];
      if (x - half - 1 >= 0) sum -= column[std::size_t(x - half - 1)];
      const int columns = std::min(w - 1, x + half) - std::max(0, x - half) + 1;
      out.at(x, y) = float(sum / (rows * columns));
    }
  }
  return out;
}

Raster<double> values_of(const GreyImage& image, double (*of)(double)) {
  Raster<double> out(image.width, image.height);
  for (std::size_t i = 0; i < image.data.size(); ++i) out.data[i] = of(image.data[i]);
  return out;
}

// Mean over the pairs with the right and the lower neighbour of each pixel.
FloatImage pair_mean(const GreyImage& image, int side, double (*of)(double)) {
  Raster<double> sums(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const int here = image.at(x, y) / 8;
      const int right = image.at(std::min(x + 1, image.width - 1), y) / 8;
      const int lower = image.at(x, std::min(y + 1, image.height - 1)) / 8;
      sums.at(x, y) = (of(here - right) + of(here - lower)) / 2;
    }
  return window_mean(sums, side);
}

}  // namespace

FloatImage entropy_of(const GreyImage& image, int side) {
  FloatImage out(image.width, image.height);
  for (int y = 0; y < image.height; ++y) {
    const std::vector<float> row = entropy_of_row(image, side, y);
    std::copy(row.begin(), row.end(), out.row(y));
  }
  return out;
}

std::vector<float> entropy_of_row(const GreyImage& image, int side, int y) {
  COLLINEA_CHECK(side >= 3 && side % 2 == 1);
  const int w = image.width, h = image.height, half = side / 2;
  // A column enters before one leaves: for a moment a grey value may have so many pixels.
  std::vector<double> n_log_n(std::size_t(side * (side + 1) + 1), 0);
  for (std::size_t n = 2; n < n_log_n.size(); ++n) n_log_n[n] = double(n) * std::log2(double(n));
  std::vector<float> out;
  out.reserve(std::size_t(w));
  std::array<int, 256> count{};
  double sum = 0;  // of n log2 n over the grey values
  const int top = std::max(0, y - half), bottom = std::min(h - 1, y + half);
  const auto add = [&](int x, int by) {
    for (int row = top; row <= bottom; ++row) {
      int& n = count[image.at(x, row)];
      sum -= n_log_n[std::size_t(n)];
      n += by;
      sum += n_log_n[std::size_t(n)];
    }
  };
  for (int x = 0; x < std::min(half, w); ++x) add(x, 1);
  for (int x = 0; x < w; ++x) {
    if (x + half < w) add(x + half, 1);
    if (x - half - 1 >= 0) add(x - half - 1, -1);
    const double pixels = (bottom - top + 1) * (std::min(w - 1, x + half) - std::max(0, x - half) + 1);
    out.push_back(float(std::max(0.0, std::log2(pixels) - sum / pixels)));
  }
  return out;
}

GreyImage entropy_mask(const FloatImage& entropy, double threshold) {
  GreyImage mask(entropy.width, entropy.height);
  for (std::size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = double(entropy.data[i]) > threshold ? 255 : 0;
  return mask;
}

Texture texture_of(const GreyImage& image, int side) {
  COLLINEA_CHECK(side >= 3 && side % 2 == 1);
  Texture out;
  out.mean = window_mean(values_of(image, [](double g) { return g; }), side);
  out.deviation = window_mean(values_of(image, [](double g) { return g * g; }), side);
  for (std::size_t i = 0; i < out.mean.data.size(); ++i) {
    const double mean = out.mean.data[i];
    out.deviation.data[i] = float(std::sqrt(std::max(0.0, out.deviation.data[i] - mean * mean)));
  }
  out.entropy = entropy_of(image, side);
  out.contrast = pair_mean(image, side, [](double d) { return d * d; });
  out.homogeneity = pair_mean(image, side, [](double d) { return 1 / (1 + d * d); });
  return out;
}

}  // namespace collinea
