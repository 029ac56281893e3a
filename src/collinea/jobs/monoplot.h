// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/io/photo_frame.h"
#include "collinea/report/monoplot_report.h"

namespace collinea {

struct MonoplotTableOptions {
  PhotoOptions photo;
  std::optional<double> sigma;
  std::optional<std::filesystem::path> surface_sigma;
  std::optional<double> sigma_height_m;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = MonoplotTableOptions;
    visit(Part{&O::photo});
    visit(
        Field{"sigma", &O::sigma, "",
              "standard deviation of an image coordinate that states none, in the unit of the table; nothing: 1 px or "
              "0.01 mm",
              1e-12, 1e6});
    visit(Field{"surface_sigma", &O::surface_sigma, "",
                "raster of the standard deviations of the heights, in the cells of the surface"}
              .leads_to(PathKind::kFile));
    visit(Field{"sigma_height_m", &O::sigma_height_m, "m",
                "standard deviation of a height that states none; nothing: exact, or where a raster of them has no "
                "value unknown",
                0, 1e6});
  }
};

/// Ground points of a table of measurements (image, point, x, y, sigma) by exterior orientations (image, X, Y, Z,
/// omega, phi, kappa, with sigma_ and correlation_ columns where known) and a raster of heights in the same
/// coordinates. All images are of one camera. Errors: tables, rasters, options; stopped.
[[nodiscard]] Result<MonoplotReport> monoplot_from_tables(const std::filesystem::path& measurements,
                                                          const std::filesystem::path& orientation,
                                                          const std::filesystem::path& surface,
                                                          const MonoplotTableOptions& options, const Run& run);

}  // namespace collinea
