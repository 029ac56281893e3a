// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/io/photo_frame.h"
#include "collinea/report/triplet_report.h"

namespace collinea {

struct TripletOptions {
  PhotoOptions photo;
  RelativeOptions adjustment;
  std::optional<double> sigma = {};
  std::optional<double> base_m = {};
  std::uint64_t seed = 1;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = TripletOptions;
    visit(Part{&O::photo});
    visit(Field{"sigma", &O::sigma, "",
                "standard deviation of a coordinate where the table states none, in its unit; nothing: 0.5 px or 0.005 "
                "mm, and sigma0 tells the true size",
                1e-9, 1e6});
    visit(Part{&O::adjustment});
    visit(Field{"base_m", &O::base_m, "m",
                "distance of the first two images; nothing: model coordinates are in units of it", 1e-9, 1e9});
    visit(Field{"seed", &O::seed, "", "of the samples of the robust starts: same seed, same result"});
  }
};

/// Three images of a table (image point x y, and sigma where it is known) joined: the relative orientations of images
/// 1-2 and 2-3 in order of appearance, the sixteen combinations of their four solutions each and the choice of one
/// (join_three_images), then least squares of all bundles (adjust_bundles). Data snooping of the last leaves out
/// measurements where rejection is asked for, one of a point at a time. Errors: file, columns, another number of images
/// than three, no principal distance, pairs that determine no orientation, fewer than two common points with depth.
[[nodiscard]] Result<TripletReport> orient_triplet(const std::filesystem::path& measurements,
                                                   const TripletOptions& options);

}  // namespace collinea
