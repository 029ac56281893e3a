// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/dense/internal/disparity_map.h"
#include "collinea/raster/raster.h"

namespace collinea {

struct StereoOptions {
  StereoCost cost = StereoCost::kCensus;
  int max_left_right_px = 1;
  int min_patch_px = 100;
  double min_correlation = 0.5;
  double max_sigma_px = 0.5;
  bool fill = false;

  friend bool operator==(const StereoOptions&, const StereoOptions&) = default;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = StereoOptions;
    visit(Field{"cost", &O::cost, "", "of dense: how unlike two pixels are"});
    visit(Field{"max_left_right_px", &O::max_left_right_px, "px",
                "largest difference between what is found from the left and from the right, in whole pixels", 0, 100});
    visit(Field{"min_patch_px", &O::min_patch_px, "px", "what hangs together less is left out", 0, 1e6});
    visit(Field{"min_correlation", &O::min_correlation, "1", "of dense: smallest correlation of an accepted match", -1,
                1});
    visit(Field{"max_sigma_px", &O::max_sigma_px, "px",
                "of dense: largest standard deviation of an accepted disparity; less texture is left empty", 0.01,
                100});
    visit(Field{"fill", &O::fill, "", "fill what is left out from what lies around it; no sigma tells where"});
  }
};

/// Both images rectified: what is in row y of one is in row y of the other. Grey value 0 means "nothing there".
/// Semi-global matching (Hirschmueller 2008) with `options.cost`, in both directions, measured again by correlation.
/// Rims of what lies in front that are more like what lies behind are emptied, as in depth maps.
/// Memory: a byte for every pixel and disparity, at most 400 MB, and about 50 bytes a pixel. Same bits for any number
/// of threads. Errors: images of different heights, an empty image, a range that is empty, has more than 2000
/// disparities or lies beyond the images, stopped.
[[nodiscard]] Result<DisparityMap> match_pair(const GreyImage& left, const GreyImage& right,
                                              const DisparityRange& range, const StereoOptions& options,
                                              const Run& run);

/// Fills the holes of a disparity map from the nearest values to their left and right: by the smaller disparity of the
/// two, which is the farther surface, for hidden points lie beside what hides them. Rows with nothing at all stay
/// empty.
void fill_disparities(FloatImage& disparity);

}  // namespace collinea
