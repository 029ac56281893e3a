// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/report/measured_report.h"

namespace collinea {

struct MeasurePointsOptions {
  double sigma_px = 0.5;
  std::string figures;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = MeasurePointsOptions;
    visit(Field{"sigma_px", &O::sigma_px, "px", "standard deviation of a mark that states none", 1e-3, 1000});
    visit(
        Field{"figures", &O::figures, "",
              "what is measured of the points, a word and their names: \"distance A B; area A B C D\", or a file with "
              "one in each line"}
            .leads_to(PathKind::kFileOrWord));
  }
};

/// Points of a table of marks (image, point, x, y, sigma) in the oriented images of a project, adjusted with the whole
/// block, and figures of them: with the covariances of the block, which points have in common. The project stays as it
/// is. Errors: not oriented yet, table, images that there are not, figures of points that there are not; those of
/// MarkedBlock.
[[nodiscard]] Result<MeasuredReport> measure_points(const std::filesystem::path& project,
                                                    const std::filesystem::path& marks,
                                                    const MeasurePointsOptions& options, const Run& run);

}  // namespace collinea
