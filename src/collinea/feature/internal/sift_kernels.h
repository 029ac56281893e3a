// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

// The inner loops of SIFT on plain pointers, for the instruction set of the machine. Rows are rows of float pixels.
// Unless stated otherwise, a row may be read and written up to kRowSlack floats beyond its end.
namespace collinea {

inline constexpr int kRowSlack = 32;

/// out[x] = in[x], for a row of bytes; nothing is read beyond `width`.
void widen_row(const std::uint8_t* in, int width, float* out);

/// out[x] = sum over j in [-radius, radius] of taps[|j|] in[x + j]. in is readable from -radius to width + radius +
/// slack.
void filter_along_row(const float* in, int width, const float* taps, int radius, float* out);

/// out[x] = sum over j in [-radius, radius] of taps[|j|] rows[radius + j][x].
void filter_across_rows(const float* const* rows, int width, const float* taps, int radius, float* out);

/// out[x] = a[x] - b[x].
void subtract_rows(const float* a, const float* b, int width, float* out);

/// The x in [begin, end) at which the middle row of the middle plane has an extremum among its 26 neighbours whose size
/// is above the threshold. rows: 3 planes x 3 rows, [plane * 3 + row]; readable from begin - 1. Returns how many were
/// written to `found`, which has room for end - begin.
int extrema_of_row(const float* const* rows, int begin, int end, float threshold, std::int32_t* found);

/// A blurred image as the two functions below see it, or those of its rows that they need. Pixel indices are whole
/// numbers at pixel centres.
struct BlurredImage {
  const float* data;
  std::ptrdiff_t stride;  ///< floats
  int width, height;      ///< of the whole image
  int first_row = 0;      ///< that data begins with
};

inline constexpr int kDirectionBins = 36;

/// The histogram of gradient directions round (x, y), weighted by the gradient's size and a Gaussian of standard
/// deviation sigma, out to three of it. Bin b is centred on the direction 2 pi b / 36, from x to y. sigma <= 8.
void direction_histogram(const BlurredImage& image, float x, float y, float sigma, float* histogram);

/// The 4 x 4 x 8 gradient histogram [row][column][direction] of a patch round (x, y), turned by angle_rad, whose cells
/// are cell_px wide, before any normalisation. Of the rows of pixels every row_step-th is looked at, the one nearest to
/// y among them. cell_px <= 18.
void gradient_patch(const BlurredImage& image, float x, float y, float angle_rad, float cell_px, int row_step,
                    float* histogram);

}  // namespace collinea
