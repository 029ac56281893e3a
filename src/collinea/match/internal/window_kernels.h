// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "collinea/raster/raster.h"

// The inner loops of matching a window in another image on plain pointers, for the instruction set of the machine;
// every machine gives the same bits.
namespace collinea {

/// Points of a window count in groups of so many; arrays of one float a point are filled up to a multiple.
inline constexpr int kPointGroup = 16;
inline constexpr int kWindowColumns = 8;  // derivatives by position, map, gain and offset

/// Where the points (u, v) of a window lie in an image: position + map (u, v).
struct WindowPlacement {
  Eigen::Vector2d position_px;
  Eigen::Matrix2d map;
};

/// Grey values and slopes of the image smoothed by the cubic B-spline (spline_window.h) at `count` points, a multiple
/// of kPointGroup. False, with nothing of use in the output, when a point lies less than two pixels inside.
/// Positions are exact to 2e-5 px for windows of 100 pixels, wherever these lie in the image.
[[nodiscard]] bool sample_spline(const GreyImage& image, const WindowPlacement& placement, const float* u,
                                 const float* v, int count, float* grey, float* slope_x, float* slope_y);

/// out[k] = sum over `count` points of columns[k * count + point] * values[point], k < kWindowColumns.
void column_products(const float* columns, const float* values, int count, float* out);

/// What noise of single pixels does to the kWindowColumns sums of column * grey value over the points of a window: a
/// linear form of the pixels of a frame `width` pixels wide, kWindowColumns numbers a pixel, pixel by pixel.
/// `placement` is in pixels of the frame, all points two pixels inside. Adds to `forms`, and returns the sum over the
/// points of weight * (variance of the grey value of a point, for noise of 1).
double add_noise_forms(const WindowPlacement& placement, const float* u, const float* v, const float* weight,
                       const float* columns, int points, int count, int width, float* forms);

/// out(i, k) = sum over pixels of forms[pixel, i] * forms[pixel, k], rows of kWindowColumns.
void forms_products(const float* forms, int pixels, float* out);

}  // namespace collinea
