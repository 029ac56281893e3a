// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/assess/height_comparison.h"
#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/report/evaluation_text.h"

namespace collinea {

/// How a surface is compared with its reference.
struct EvaluateOptions {
  Coregistration coregistration = Coregistration::kShift;
  std::optional<double> tolerance_m;
  std::optional<double> scale_number, height_over_base, sigma_image_um;
  double sigma_reference_m = 0;
  std::optional<std::string> area;
  std::optional<std::filesystem::path> classes, out;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = EvaluateOptions;
    visit(Field{"coregistration", &O::coregistration, "",
                "taken off before the comparison"});
    visit(Field{"tolerance_m", &O::tolerance_m, "m",
                "sigma of a difference, whose multiples the table counts; nothing: from the next four, else the robust "
                "standard deviation of the differences",
                1e-9, 1e6});
    visit(Field{"scale_number", &O::scale_number, "1", "of the photographs (6800 for 1:6800): for the predicted sigma",
                1, 1e7});
    visit(Field{"height_over_base", &O::height_over_base, "1", "flying height over base, for the predicted sigma", 0.01,
                1e4});
    visit(Field{"sigma_image_um", &O::sigma_image_um, "um", "of a parallax in the photograph, for the predicted sigma",
                1e-3, 1e4});
    visit(Field{"sigma_reference_m", &O::sigma_reference_m, "m",
                "of the reference's heights, added to the predicted sigma as squares", 0, 1e4});
    visit(Field{"area", &O::area, "m",
                "west,south,east,north on the map: only what of the reference lies in it takes part; nothing: all"});
    visit(
        Field{"classes", &O::classes, "",
              "GeoTIFF of whole numbers on the map: statistics of each; nothing: NAME_state.tif beside the surface, if "
              "it is there"}
            .leads_to(PathKind::kFile));
    visit(Field{"out", &O::out, "", "folder for evaluation.txt, differences.tif and differences.png; made when missing"}
              .leads_to(PathKind::kOutput));
  }
};

/// Compares a surface (GeoTIFF of heights) with a reference: a GeoTIFF of heights, a cloud (LAS, LAZ, PLY) or a text
/// table with columns X, Y, Z [m], all in one CRS. Errors: files, options, nothing in common, cancelled.
[[nodiscard]] Result<Evaluation> evaluate_surface(const std::filesystem::path& surface,
                                                  const std::filesystem::path& reference,
                                                  const EvaluateOptions& options, const Run& run);

}  // namespace collinea
