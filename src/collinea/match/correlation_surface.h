// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/base/words.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// How alike two windows T and S of n pixels are.
enum class Similarity { kNcc, kSsd, kSad, kRank, kCensus, kD, kDn, kCosine };
inline constexpr Word<Similarity> kSimilarityWords[] = {
    {Similarity::kNcc, "ncc",
     "correlation coefficient cov(T, S) / (s_T s_S): -1 to 1, blind to brightness and contrast"},
    {Similarity::kSsd, "ssd", "sum of the squared differences of grey values"},
    {Similarity::kSad, "sad", "sum of their absolute differences"},
    {Similarity::kRank, "rank", "sum of the absolute differences of ranks: how many neighbours are darker"},
    {Similarity::kCensus, "census", "number of neighbours that are darker in one window and not in the other"},
    {Similarity::kD, "d", "root of ssd"},
    {Similarity::kDn, "dn", "root of the mean squared difference"},
    {Similarity::kCosine, "cosine",
     "correlation without the means, sum TS / root(sum T^2 sum S^2): 0 to 1, blind to contrast but not to brightness"},
};
constexpr std::span<const Word<Similarity>> words(Similarity) { return kSimilarityWords; }

/// Whether larger values are more alike: of the correlations, with and without the means.
[[nodiscard]] constexpr bool is_larger_better(Similarity similarity) {
  return similarity == Similarity::kNcc || similarity == Similarity::kCosine;
}

/// Similarities of a template to a search area: values.at(x, y) is that of the window of the other image whose middle
/// is the pixel (left + x, top + y).
struct CorrelationSurface {
  Similarity method = Similarity::kNcc;
  int pixels = 0;  ///< of the template
  int left = 0, top = 0;
  FloatImage values;
  FloatImage
      deviations;  ///< of ncc: roots of the windows' sums of squares about their means [grey]; of cosine: about 0
};

/// Compares the template of `half` pixels to each side of the middle pixel with the windows of `other` whose middles
/// lie in a square of `range` pixels to each side of `expected`, as far as the image holds them. The correlation of a
/// constant window (of cosine: a black one) is 0. neighbourhood_px: 3, 5 or 7, of rank and census; pixels so near to
/// the border of an image compare with the nearest in it. Exact whole numbers up to 2^24. Empty when the template does
/// not lie in its image, or no window in the other. Cost: range^2 half^2 * 16 products and sums, 21 x 21 in 201 x 201
/// below a millisecond (ncc, cosine, ssd, d, dn).
[[nodiscard]] CorrelationSurface correlation_surface(const GreyImage& image, const Eigen::Vector2i& middle, int half,
                                                     const GreyImage& other, const Eigen::Vector2i& expected, int range,
                                                     Similarity method, int neighbourhood_px = 5);

}  // namespace collinea
