// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "collinea/base/run.h"
#include "collinea/base/words.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// From which pixels one of a smaller image is made (Mussio 6.2).
enum class Reduction : std::uint8_t { kMean, kSinc, kMedian };
inline constexpr Word<Reduction> kReductionWords[] = {
    {Reduction::kMean, "mean", "of the area that the new pixel covers"},
    {Reduction::kSinc, "sinc",
     "the ideal low pass, cut at three zeros: keeps what the new pixels can show, and no more"},
    {Reduction::kMedian, "median", "of the pixels whose middles it covers: what is wrong in single pixels goes"}};
[[nodiscard]] constexpr std::span<const Word<Reduction>> words(Reduction) { return kReductionWords; }

/// An image with pixels `factor` >= 1 times as large, ceil(w / factor) x ceil(h / factor); a point at (x, y) is at (x,
/// y) / factor. With s = 1 / factor and d the distance from the middle of the new pixel:
///     mean    K = s in |d| <= 1 / (2 s), pixels at its ends by their part
///     sinc    K = s sinc(s d) sinc(s d / 3) in |d| < 3 / s, sinc(t) = sin(pi t) / (pi t); cut with a window in place
///     of
///             the source's abrupt end (Duchon 1979), which would make ripples
/// in each direction, weights made to sum to 1 (the source's do so within its window only), beside the border among the
/// pixels there are. (Mussio E42 and E43 print K with cases exchanged and sinc without pi s.) Rounded, any channels.
/// Single rows are held beside image and result. Factor 1: the same image.
[[nodiscard]] Raster<std::uint8_t> reduced(const Raster<std::uint8_t>& image, double factor, Reduction reduction,
                                           const Run& run);

/// The same of an image with empty pixels, where the mask `known` is 0: they do not count, and a pixel of which they
/// have more than half of the weight (median: of the number) is empty.
struct ReducedPart {
  Raster<std::uint8_t> image;  ///< 0 where it is empty
  GreyImage known;             ///< 255, or 0
};
[[nodiscard]] ReducedPart reduced(const Raster<std::uint8_t>& image, const GreyImage& known, double factor,
                                  Reduction reduction, const Run& run);

}  // namespace collinea
