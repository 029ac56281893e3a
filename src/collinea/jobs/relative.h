// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/io/photo_frame.h"
#include "collinea/report/relative_report.h"

namespace collinea {

struct RelativePairOptions {
  PhotoOptions photo;
  RelativeOptions adjustment;
  std::optional<double> sigma = {};
  bool estimate_sigma = false;
  std::optional<double> base_m = {};
  std::optional<std::filesystem::path> distances = {};
  std::uint64_t seed = 1;
  std::optional<std::filesystem::path> out = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = RelativePairOptions;
    visit(Part{&O::photo});
    visit(Field{"sigma", &O::sigma, "",
                "standard deviation of a coordinate where the table gives none, in its unit; nothing: found from the "
                "residuals",
                1e-9, 1e6});
    visit(Field{"estimate_sigma", &O::estimate_sigma, "",
                "multiply standard deviations by sigma0, even where they are given"});
    visit(Part{&O::adjustment});
    visit(Field{"base_m", &O::base_m, "m", "length of the base; nothing: model coordinates are in units of the base",
                1e-9, 1e9});
    visit(Field{"distances", &O::distances, "",
                "table of distances measured between points: from to distance[m] sigma[m]; they give the base"}
              .leads_to(PathKind::kFile));
    visit(Field{"seed", &O::seed, "", "of the samples of the robust start: same seed, same result"});
    visit(Field{"out", &O::out, "",
                "folder for the tables (parameters, residuals, model coordinates, exterior orientation) and the "
                "picture of the pair's geometry"}
              .leads_to(PathKind::kFolder));
  }
};

/// The relative orientation of the pair of images in a table: point x_left y_left x_right y_right, and sigma where it
/// is known (coordinates in px with y down, or in mm or um with y up). Errors: file, columns, no principal distance,
/// points that determine no orientation.
[[nodiscard]] Result<RelativeReport> orient_pair(const std::filesystem::path& measurements,
                                                 const RelativePairOptions& options);

}  // namespace collinea
