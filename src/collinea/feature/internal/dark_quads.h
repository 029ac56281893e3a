// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "collinea/raster/raster.h"

namespace collinea {

/// Corners of a quadrilateral, clockwise in the image (x right, y down).
using Quad = std::array<Eigen::Vector2d, 4>;

/// Dark quadrilaterals on light ground, to some tenths of a pixel: what is darker than the middle between the extremes
/// of its neighbourhood of 12 x 12 pixels, connected, with an outline of four straight sides. Their sides are fitted to
/// where the grey values rise. `least_contrast` [grey]: of the extremes, and half of that across most of each side.
/// `least_side_px`: of each side. Cost: a tenth of a second for ten million pixels.
[[nodiscard]] std::vector<Quad> dark_quads(const FloatImage& image, double least_contrast, double least_side_px);

/// The quadrilateral about a convex polygon (clockwise) whose area exceeds it least, built by extending sides over
/// others one after the other. Nothing: fewer than four vertices, or sides that run apart.
[[nodiscard]] std::vector<Eigen::Vector2d> quad_about(std::vector<Eigen::Vector2d> polygon);

}  // namespace collinea
