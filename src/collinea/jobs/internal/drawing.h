// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "collinea/raster/raster.h"

// Lines and marks on an image, one pixel wide; what lies outside is left out. Positions in px.
namespace collinea {

using MarkColour = std::array<std::uint8_t, 3>;
inline constexpr MarkColour kMarkRed = {230, 40, 30}, kMarkBlue = {30, 110, 240};

/// A grey image in colours, to be drawn on.
[[nodiscard]] inline ColourImage to_draw_on(const GreyImage& image) {
  ColourImage out(image.width, image.height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) std::fill_n(&out.data[3 * i], 3, image.data[i]);
  return out;
}

inline void draw_point(ColourImage& image, const Eigen::Vector2d& p, const MarkColour& colour) {
  if (!(p.x() >= 0 && p.y() >= 0 && p.x() < image.width && p.y() < image.height)) return;
  for (int c = 0; c < 3; ++c) image.at(int(p.x()), int(p.y()), c) = colour[std::size_t(c)];
}

inline void draw_line(ColourImage& image, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                      const MarkColour& colour) {
  const double length = (to - from).cwiseAbs().maxCoeff();
  if (!(length < 1e6)) return;
  const int steps = std::max(1, int(length * 2));
  for (int i = 0; i <= steps; ++i) draw_point(image, from + (to - from) * i / steps, colour);
}

inline void draw_curve(ColourImage& image, std::span<const Eigen::Vector2d> curve, bool is_closed,
                       const MarkColour& colour) {
  for (std::size_t i = 1; i < curve.size(); ++i) draw_line(image, curve[i - 1], curve[i], colour);
  if (is_closed && curve.size() > 2) draw_line(image, curve.back(), curve.front(), colour);
}

inline void draw_cross(ColourImage& image, const Eigen::Vector2d& at, double reach_px, const MarkColour& colour) {
  draw_line(image, at - Eigen::Vector2d(reach_px, 0), at + Eigen::Vector2d(reach_px, 0), colour);
  draw_line(image, at - Eigen::Vector2d(0, reach_px), at + Eigen::Vector2d(0, reach_px), colour);
}

inline void draw_circle(ColourImage& image, const Eigen::Vector2d& middle, double radius_px, const MarkColour& colour) {
  const int steps = std::max(8, int(std::ceil(8 * radius_px)));
  for (int k = 0; k < steps; ++k) {
    const double angle = 2 * std::numbers::pi * k / steps;
    draw_point(image, middle + radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)), colour);
  }
}

}  // namespace collinea
