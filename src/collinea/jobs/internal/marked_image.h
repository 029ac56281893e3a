// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "collinea/raster/raster.h"

namespace collinea {

using MarkColour = std::array<std::uint8_t, 3>;
inline constexpr MarkColour kMarkRed = {230, 40, 30}, kMarkBlue = {30, 110, 240};

/// A grey image in colours, with marks drawn on it. Positions in pixels; what lies beside the image is left out.
class MarkedImage {
 public:
  explicit MarkedImage(const GreyImage& image);
  void cross(const Eigen::Vector2d& at, int arm_px, const MarkColour& colour);
  void circle(const Eigen::Vector2d& at, double radius_px, const MarkColour& colour);
  [[nodiscard]] ColourImage image() && { return std::move(image_); }

 private:
  void dot(int column, int row, const MarkColour& colour);
  ColourImage image_;
};

}  // namespace collinea
