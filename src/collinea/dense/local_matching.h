// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/dense/internal/disparity_map.h"
#include "collinea/match/area_matching.h"

namespace collinea {

struct LocalOptions {
  Similarity similarity = Similarity::kNcc;
  int window_px = 9;
  int neighbourhood_px = 5;
  double decisive_ratio = 1;

  friend bool operator==(const LocalOptions&, const LocalOptions&) = default;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = LocalOptions;
    visit(Field{"local_cost", &O::similarity, "", "what is compared"});
    visit(Field{"local_window_px", &O::window_px, "px", "side of the window, odd", 3, 101});
    visit(Field{"local_neighbourhood_px", &O::neighbourhood_px, "px",
                "side of the neighbourhood of rank and census: 3, 5 or 7", 3, 7});
    visit(Field{"local_decisive_ratio", &O::decisive_ratio, "",
                "the best disparity is taken when all but its neighbours have more than so many times its residual "
                "variance (ncc: 1 - correlation squared)",
                1, 1e6});
  }
};

/// A disparity map whose every pixel is decided by its own window.
struct LocalLimits {
  int max_left_right_px = 1;  ///< between the best from the left and from the right, in whole pixels
  int min_patch_px = 100;     ///< patches of fewer pixels are left empty
};

/// Both images rectified; grey value 0 means "nothing there". The similarities of area_matching.h, of square windows
/// round every pixel and every disparity that the right image has there; the best wins, whatever its neighbours say
/// (local matching, "winner takes all": Scharstein and Szeliski 2002). Beyond the border images repeat. Disparities
/// between the pixels are the top of the parabola through the best and its neighbours, of ssd, d and dn that of the
/// squared differences: these three order windows alike and give the same map. Empty (NaN) where
///   - the window of the left image is constant, or the right image has nothing;
///   - the best lies at an end of what is searched, where it may lie beyond;
///   - another disparity is as good (LocalOptions::decisive_ratio);
///   - the right image prefers another pixel, or the patch is small (LocalLimits).
/// Sigmas as those of subpixel_peak(), along the row alone: with the least value O, the second difference H and n
/// pixels
///     var = 2 O / (n - 4) / H + O^2 / (2 (n - 4)) / H^2,  of sad pi/2 sad/n / H + 0.315 / 2 sad^2/n / H^2
/// for white noise and a window that has one disparity, without what a parabola over whole pixels adds; of rank and
/// census none. Sums over windows slide along columns and rows: time does not depend on the size of the window. Memory:
/// 4 bytes for every column and disparity per thread. Same bits for any number of threads. Errors: as match_pair(),
/// fewer than three disparities, even windows.
[[nodiscard]] Result<DisparityMap> match_locally(const GreyImage& left, const GreyImage& right,
                                                 const DisparityRange& range, const LocalOptions& options,
                                                 const LocalLimits& limits, const Run& run);

}  // namespace collinea
