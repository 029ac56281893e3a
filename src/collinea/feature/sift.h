// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/block/features.h"
#include "collinea/raster/raster.h"

namespace collinea {

struct SiftOptions {
  int max_features = 8192;
  double peak_threshold = 0.002;
  double edge_ratio = 10;
  std::optional<bool> upsample;
  double evenness = 0.5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = SiftOptions;
    visit(Field{"max_features", &O::max_features, "1", "most features kept of one image", 1, 1e6});
    visit(Field{"peak_threshold", &O::peak_threshold, "1",
                "least contrast of a feature, as a part of the range from black to white", 0.0, 1.0});
    visit(Field{"edge_ratio", &O::edge_ratio, "1", "largest ratio of the two principal curvatures", 1.0});
    visit(Field{"upsample", &O::upsample, "1",
                "look for features finer than the pixels; by default for images below 2.5 megapixels"});
    visit(Field{"evenness", &O::evenness, "1",
                "how evenly features are spread: 0 = the strongest, wherever they are, 1 = as many in every region",
                0.0, 1.0});
  }
};

/// Scale-invariant features (Lowe 2004) with RootSIFT descriptors (Arandjelovic and Zisserman 2012), strongest first.
/// A keypoint's position is good to a few hundredths of a pixel of its octave; a position with two or three distinct
/// gradient directions gives as many features. A descriptor is the square root of the L1-normalised SIFT descriptor,
/// times 512, rounded, at most 127; hence its L2 norm is about 512.
///
/// Unlike Lowe: gradients are taken over patches of three sizes (Dong and Soatto 2015). The weak peaks are kept at
/// first; of all of them the strongest are taken, where strength is counted in part beside that of the neighbours
/// (SiftOptions::evenness, regional_strengths).
///
/// Single-threaded and without chance: the same image gives the same bits. An image of less than 16 pixels in width or
/// height has no features. Where the levels of an octave take more than `most_kept_bytes` they are made twice more, a
/// few rows at a time, with the same result.
inline constexpr std::size_t kMostKeptBytes = std::size_t{320} << 20;
[[nodiscard]] Features detect_sift(const GreyImage& image, const SiftOptions& options,
                                   std::size_t most_kept_bytes = kMostKeptBytes);

/// The memory that takes, with the image: 18 bytes a pixel (67 when upsampled) of images of up to 26 megapixels; of the
/// finest octaves of larger ones a few rows at a time are held, twice for description, and 2.3 bytes a pixel are left.
[[nodiscard]] std::size_t bytes_to_detect_sift(int width, int height, const SiftOptions& options);

}  // namespace collinea
