// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

// The inner loops of area matching on plain pointers, for the instruction set of the machine; whole numbers, so that
// every machine gives the same bits.
namespace collinea {

/// Rows are read and written up to so many columns beyond their end.
inline constexpr int kAreaPadding = 64;

/// out[y * out_stride + x] = sum over the template's pixels (u, v) of template * searched pixel (x + u, y + v), for
/// y < rows, x < columns (and some beyond). `pairs`: searched rows of two neighbouring grey values each, the left one
/// in the low half; padded by kAreaPadding. `halves`: the template the same way, every second pair of a row (0 beyond
/// its end), half_width of them a row. Sums must fit into 31 bits.
void cross_products(const std::int32_t* pairs, std::ptrdiff_t stride, const std::int32_t* halves, int half_width,
                    int template_rows, int rows, int columns, std::int32_t* out, std::ptrdiff_t out_stride);

/// Correlation coefficients of windows of n pixels: (n product - sum template_sum) / sqrt((n square - sum^2) spread), 0
/// where the window is constant; deviations: roots of the windows' sums of squares about their mean; spread = n times
/// the template's squares less its sum squared.
void correlations(const std::int32_t* products, const std::int32_t* sums, const std::int32_t* squares,
                  std::size_t count, double n, double template_sum, double spread, float* out, float* deviations);

}  // namespace collinea
