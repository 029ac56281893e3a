// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/marked_image.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {

MarkedImage::MarkedImage(const GreyImage& image) : image_(image.width, image.height, 3) {
  for (std::size_t i = 0; i < image.data.size(); ++i) std::fill_n(&image_.data[3 * i], 3, image.data[i]);
}

void MarkedImage::dot(int column, int row, const MarkColour& colour) {
  if (column < 0 || row < 0 || column >= image_.width || row >= image_.height) return;
  std::copy(colour.begin(), colour.end(), image_.row(row) + 3 * column);
}

void MarkedImage::cross(const Eigen::Vector2d& at, int arm_px, const MarkColour& colour) {
  const int column = static_cast<int>(std::floor(at.x())), row = static_cast<int>(std::floor(at.y()));
  for (int k = -arm_px; k <= arm_px; ++k) {
    dot(column + k, row, colour);
    dot(column, row + k, colour);
  }
}

void MarkedImage::circle(const Eigen::Vector2d& at, double radius_px, const MarkColour& colour) {
  const int steps = std::max(8, static_cast<int>(std::ceil(8 * radius_px)));
  for (int k = 0; k < steps; ++k) {
    const double angle = 2 * std::numbers::pi * k / steps;
    dot(static_cast<int>(std::floor(at.x() + radius_px * std::cos(angle))),
        static_cast<int>(std::floor(at.y() + radius_px * std::sin(angle))), colour);
  }
}

}  // namespace collinea
