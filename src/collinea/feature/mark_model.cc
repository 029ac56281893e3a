// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/mark_model.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kSpacing = 0.25;  // of drawn templates [px]
constexpr double kBlurs_px[] = {0.4, 0.6, 0.85, 1.2, 1.6, 2.05, 2.6};

// Whether a position, from the mark and along its axis, lies on the drawing.
bool is_drawn(MarkKind kind, const Vector2d& at, double size, double line) {
  const double r = at.norm(), half = size / 2;
  switch (kind) {
    case MarkKind::kCross:
      return std::max(std::abs(at.x()), std::abs(at.y())) <= half &&
             std::min(std::abs(at.x()), std::abs(at.y())) <= line / 2;
    case MarkKind::kDot:
      return r <= half;
    case MarkKind::kRing:
      return r <= half && r >= half - line;
    case MarkKind::kCorner: {
      // Arms at 45 degrees to both sides of the axis; the mark is where their middle lines meet.
      const double u = (at.x() + at.y()) / std::sqrt(2.0), v = (at.x() - at.y()) / std::sqrt(2.0);
      return u >= -line / 2 && v >= -line / 2 && std::max(u, v) <= half && std::min(u, v) <= line / 2;
    }
    case MarkKind::kNotch:
      return at.x() >= std::min(std::abs(at.y()), half);
  }
  return false;
}

// Shares of lattice cells that the drawing covers. Cells whose corners and middle agree lie within or without: no line
// is narrower than two cells.
FloatImage coverage(MarkKind kind, double size, double line, double inwards, int half_cells) {
  const int width = 2 * half_cells + 1;
  constexpr int kFiner = 16;
  FloatImage image(width, width);
  const double c = std::cos(inwards), s = std::sin(inwards);
  const auto is_bright = [&](double x, double y) {
    const double u = kSpacing * (x - half_cells - 0.5), v = kSpacing * (y - half_cells - 0.5);
    return is_drawn(kind, {c * u + s * v, -s * u + c * v}, size, line);
  };
  const bool has_wide_lines = line >= 2 * kSpacing;
  for (int y = 0; y < width; ++y)
    for (int x = 0; x < width; ++x) {
      const int agree = is_bright(x, y) + is_bright(x + 1, y) + is_bright(x, y + 1) + is_bright(x + 1, y + 1) +
                        is_bright(x + 0.5, y + 0.5);
      if (has_wide_lines && agree % 5 == 0) {
        image.at(x, y) = agree == 0 ? 0.0F : 1.0F;
        continue;
      }
      int drawn = 0;
      for (int k = 0; k < kFiner * kFiner; ++k) {
        // A lattice that is turned: edges along the cells or their diagonals cross it at 256 positions, not at 16; and
        // of an even number, so that edges through the middle of the mark meet none of its points.
        const double i = k % kFiner + 0.5, j = k / kFiner + 0.5;
        drawn +=
            is_bright(x + (i + (j - kFiner / 2.0) / kFiner) / kFiner, y + (j - (i - kFiner / 2.0) / kFiner) / kFiner);
      }
      image.at(x, y) = float(drawn) / float(kFiner * kFiner);
    }
  return image;
}

FloatImage transposed(const FloatImage& image) {
  FloatImage out(image.height, image.width);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) out.at(y, x) = image.at(x, y);
  return out;
}

FloatImage blurred_along_rows(const FloatImage& image, double sigma) {
  const int reach = int(std::ceil(3.5 * sigma));
  std::vector<float> kernel;
  float sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    kernel.push_back(float(std::exp(-0.5 * k * k / (sigma * sigma))));
    sum += kernel.back();
  }
  FloatImage out(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      float value = 0;
      for (int k = -reach; k <= reach; ++k)
        value += kernel[std::size_t(k + reach)] * image.at(std::clamp(x + k, 0, image.width - 1), y);
      out.at(x, y) = value / sum;
    }
  return out;
}

// Means of what a pixel is wide: four cells, the outer two of five by half.
FloatImage gathered_along_rows(const FloatImage& image) {
  static_assert(kSpacing == 0.25);
  FloatImage out(image.width, image.height);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto at = [&](int k) { return image.at(std::clamp(x + k, 0, image.width - 1), y); };
      out.at(x, y) = 0.25F * (at(-1) + at(0) + at(1)) + 0.125F * (at(-2) + at(2));
    }
  return out;
}

// Light blurred, then gathered by pixels.
FloatImage blurred(const FloatImage& image, double sigma) {
  const auto along_rows = [&](const FloatImage& from) { return gathered_along_rows(blurred_along_rows(from, sigma)); };
  return transposed(along_rows(transposed(along_rows(image))));
}

}  // namespace

MarkModel drawn_mark(MarkKind kind, double size_px, double line_px, double inwards_rad) {
  const int half_cells = int(std::ceil((0.75 * size_px + 5) / kSpacing));
  const FloatImage sharp = coverage(kind, size_px, line_px, inwards_rad, half_cells);
  MarkModel model;
  for (const double blur : kBlurs_px)
    model.blurred.push_back(
        {blurred(sharp, blur / kSpacing), kSpacing, blur, Vector2d(half_cells + 0.5, half_cells + 0.5)});
  return model;
}

}  // namespace collinea
