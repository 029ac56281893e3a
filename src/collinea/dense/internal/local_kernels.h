// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

// The inner loops of local matching of a rectified pair, along a row and for one label at a time. Arrays may be read
// and written kLocalSlack elements beyond their ends.
namespace collinea::dense {

inline constexpr int kLocalSlack = 64;

/// What two pixels add to the sum over a window.
enum class PixelTerm {
  kProduct,
  kSquare,      ///< of the difference
  kDifference,  ///< without its sign
  kBits,        ///< that differ in all planes
};

inline constexpr std::size_t kMostPlanes = 6;

/// The same row of both images, byte by byte where a pixel has several.
struct PixelRows {
  std::array<const std::uint8_t*, kMostPlanes> left{}, right{};
  std::size_t planes = 1;
};

/// Adds the terms of a row to sums down the columns of windows, and takes those of another away where there is one.
void slide_columns(PixelTerm term, const PixelRows& entering, const PixelRows* leaving, int width, std::int32_t* sums);

/// Costs of the windows of a row: their sums, and infinity where a penalty is.
void costs_of_sums(const std::int32_t* sums, const float* left_penalty, const float* right_penalty, int width,
                   float* costs);

/// What correlation needs of the windows of a row beside their products.
struct WindowMoments {
  const std::int32_t* sum;
  const float* scale;  ///< 1 / root of the sum of squared deviations; 0: constant
};

/// 1 less the correlation of windows of n pixels, at least 0; infinity where a penalty is.
void costs_of_products(const std::int32_t* products, const WindowMoments& left, const WindowMoments& right, float n,
                       const float* left_penalty, const float* right_penalty, int width, float* costs);

/// What is known of the labels that each pixel of a row has seen so far. All is infinity at first, labels are -1.
struct BestLabels {
  float *best, *label;
  float *before, *after;     ///< costs of the labels next to the best
  float* second;             ///< least cost of the labels that are not next to it
  float *last, *last_but_1;  ///< costs of the last two labels
  float* earlier;            ///< least of those before
};

/// The same of the pixels of the right image.
struct BestFromRight {
  float *best, *label;
};

/// Takes the costs of the next label: of equal ones the first is the best.
void take_label(const float* costs, int label, int width, const BestLabels& left, const BestFromRight& right);

}  // namespace collinea::dense
