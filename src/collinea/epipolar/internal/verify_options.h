// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/options.h"

namespace collinea {

struct VerifyOptions {
  double max_error_px = 2.5;
  int min_inliers = 15;
  double confidence = 0.9999;
  int max_trials = 2000;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = VerifyOptions;
    visit(Field{"max_error_px", &O::max_error_px, "px",
                "largest distance of a match from the epipolar geometry; grows in proportion for images over 3000 px",
                1e-6});
    visit(Field{"min_inliers", &O::min_inliers, "1", "fewest matches of an accepted pair", 8});
    visit(Field{"confidence", &O::confidence, "1", "wanted chance of one sample without outliers", 0.0, 1.0});
    visit(Field{"max_trials", &O::max_trials, "1", "upper bound of samples drawn", 1});
  }
};

}  // namespace collinea
