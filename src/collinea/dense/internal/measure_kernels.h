// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

// The inner loops of measuring disparities again, and of smoothing surfaces, row by row.
namespace collinea::dense {

inline constexpr int kMeasureReach = 3;   ///< half the window
inline constexpr int kMeasureTrials = 3;  ///< at half a pixel less, none and half a pixel more
inline constexpr int kRowSlack = 16;      ///< elements that may be read and written beyond the end of a row

/// What the windows of a row are made of: the left image, the right one at each trial [1/16 grey value], both with
/// the middle at 0, and whether one of them is missing (-1).
struct TrialRow {
  std::int32_t *left, *missing;
  std::array<std::int32_t*, kMeasureTrials> right;
};

/// Sums down the columns of the windows.
struct ColumnSums {
  std::int32_t *left, *left_left, *missing;
  std::array<std::int32_t*, kMeasureTrials> right, right_right, left_right;
};

struct MeasuredRow {
  const float* surface;
  float *disparity, *sigma, *correlation;
};

/// Element i packs pixels i - 1 to i + 2 of a row from the lowest byte on, 0 <= i < width; the row is readable from -1
/// to width + kRowSlack + 2.
void pack_quads(const std::uint8_t* row, int width, std::int32_t* quads);

/// Fills `out` for a row of pixels. `quads`: as pack_quads() makes them of the right row; what lies beyond is taken
/// from the border.
void warp_row(const std::uint8_t* left, const std::int32_t* quads, int right_width, const float* surface, int width,
              const TrialRow& out);

/// Adds a row to the sums and takes one away, when there is one.
void slide(const TrialRow& entering, const TrialRow* leaving, int width, const ColumnSums& sums);

/// The peak of each pixel's correlations. The sums begin kMeasureReach columns before the first pixel.
void find_peaks(const ColumnSums& sums, int width, const MeasuredRow& row);

/// What a measured disparity must be to be accepted, and what becomes of it.
struct Acceptance {
  float sigma_scale = 1, sigma_floor_px = 0;  ///< sigma = hypot(scale * measured sigma, floor)
  float surface_sigma_px = 1;                 ///< the surface is an observation with this standard deviation, too
  float min_correlation = 0, max_sigma_px = 1;
};

/// Turns what find_peaks() has found into accepted disparities and their sigmas, in place: NaN where `found` is NaN and
/// where correlation or sigma are not good enough.
void accept_row(const float* found, const Acceptance& acceptance, int width, const MeasuredRow& row);

/// The median of 3 x 3; rows are readable from column -1 on.
void median_row(const std::array<const float*, 3>& rows, int width, float* out);

/// The same where not all is known: NaN do not count, of an even number the upper one of the middle two; NaN where
/// there is nothing.
void median_of_known_row(const std::array<const float*, 3>& rows, int width, float* out);

/// The mean over those of 5 x 5 that differ by at most `reach` from the middle; NaN do not count, and stay. Rows are
/// readable from column -2 on.
void mean_within_row(const std::array<const float*, 5>& rows, float reach, int width, float* out);

}  // namespace collinea::dense
