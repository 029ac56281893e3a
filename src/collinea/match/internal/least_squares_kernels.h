// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// The inner loops of least squares matching on plain pointers, for the instruction set of the machine; every machine
// gives the same bits.
namespace collinea {

/// A window has kWindow x kWindow points; arrays of one float a point are filled up to kWindowFloats.
inline constexpr int kWindow = 17;
inline constexpr int kWindowFloats = 304;  // 289 up to a multiple of 16
inline constexpr int kUnknowns = 8;        // of the affine map, gain and offset

/// Rows of `size` grey values without padding; 4 bytes beyond the last are readable.
struct GreySquare {
  const std::uint8_t* grey;
  int size;
};

/// The point (u, v) of the window lies at (x + xu u + xv v, y + yu u + yv v), whole numbers being pixel centres.
struct WindowPosition {
  float x, y, xu, xv, yu, yv;
};

/// Grey values at the points (u, v) of a window by cubic convolution (Keys 1981, a = -1/2). False, with nothing of use
/// in `out`, when a point lies less than two pixels inside.
[[nodiscard]] bool sample_window(const GreySquare& square, const WindowPosition& position, const float* u,
                                 const float* v, float* out);

/// out[i] = sum over the window's points of columns[i * kWindowFloats + point] * values[point], i < kUnknowns.
void window_products(const float* columns, const float* values, float* out);

}  // namespace collinea
