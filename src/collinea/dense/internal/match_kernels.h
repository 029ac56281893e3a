// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "collinea/raster/raster.h"

// The inner loops of matching: a cell of kCell x kCell pixels of the reference image is compared with one other
// image at a time. A region is the cell with kRadius pixels around it, rows of kRegionWidth (its last columns are
// idle).
namespace collinea::dense {

inline constexpr int kCell = 32;
inline constexpr int kCellPixels = kCell * kCell;
inline constexpr int kRadius = 3;
inline constexpr int kRegionWidth = 40;
inline constexpr int kRegionHeight = kCell + 2 * kRadius;
inline constexpr int kRegion = kRegionWidth * kRegionHeight;
inline constexpr int kCensusBits = 24;

/// An image prepared for bilinear sampling: element (i, j) packs pixels (i-1, j-1), (i, j-1), (i-1, j), (i, j) from
/// the lowest byte on, so that one load fetches all four; 0 when any of them is missing.
struct Quads {
  int width = 0, height = 0;  ///< of the image; there are (width + 1) x (height + 1) elements
  std::vector<std::int32_t> data;
};
[[nodiscard]] Quads quads_of(const GreyImage& image);

/// Where a pixel (u, v) of the reference, seen at inverse depth w, lies in another image (both of them pinhole):
/// (x z, y z, z) = h (u, v, 1) + w b.
struct Transfer {
  std::array<float, 9> h{};  ///< by rows
  std::array<float, 3> b{};
};

/// (x z, y z, z) of every pixel of a region.
struct Carried {
  alignas(64) float x[kRegion];
  alignas(64) float y[kRegion];
  alignas(64) float z[kRegion];
};

/// `w`: inverse depths of the region, whose upper-left pixel has the indices (left, top).
void carry(const Transfer& transfer, int left, int top, const float* w, Carried& carried);

/// Samples of the image at carried + (dx, dy, dz); grey value - 128, or -128 where the image has nothing.
void sample(const Quads& quads, const Carried& carried, float dx, float dy, float dz, std::int8_t* out);

/// The same without rounding of the grey value, which is minus 128, too; NaN where the image has nothing.
void sample(const Quads& quads, const Carried& carried, float dx, float dy, float dz, float* out);

/// Census of a region: for each cell pixel whether opposite pixels of the window around it rise (0 or 255).
/// `planes`: kCensusBits planes of kCellPixels.
void census(const std::int8_t* region, std::uint8_t* planes);

/// How many census bits of the region differ from `planes`; 255 where the window is not all there.
void census_distance(const std::int8_t* region, const std::uint8_t* planes, std::uint8_t* distance);

/// The three smallest distances seen so far and how many were there.
struct Smallest {
  alignas(64) std::uint8_t first[kCellPixels];
  alignas(64) std::uint8_t second[kCellPixels];
  alignas(64) std::uint8_t third[kCellPixels];
  alignas(64) std::uint8_t count[kCellPixels];
};
void clear(Smallest& smallest);
void add(const std::uint8_t* distance, Smallest& smallest);

/// The matching cost from the better half of the images (so that those in which the pixel is hidden do not count):
/// 6 per differing bit; what chance gives where no image shows the pixel.
inline constexpr int kCostPerBit = 6;
inline constexpr int kCostOfChance = kCostPerBit * kCensusBits / 2;
void cost(const Smallest& smallest, std::uint8_t* cost_of_pixel);

/// Sums over the window of (2 kRadius + 1)^2 pixels around each pixel of the cell.
struct WindowStatistics {
  alignas(64) float mean[kCellPixels];
  alignas(64) float inverse_deviation[kCellPixels];  ///< 1 / sqrt(sum of squared deviations); 0 for a flat window
};
void window_statistics(const float* region, WindowStatistics& statistics);

/// The correlation coefficient of the windows around each cell pixel of two regions; NaN where one has a hole, 0 where
/// one is flat.
void correlate(const float* reference, const WindowStatistics& of_reference, const float* other, float* correlation);

}  // namespace collinea::dense
