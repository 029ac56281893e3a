// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/dense/level_matching.h"
#include "collinea/dense/local_matching.h"
#include "collinea/dense/stereo.h"
#include "collinea/jobs/internal/stereo_pair_options.h"
#include "collinea/report/stereo_report.h"

namespace collinea {

/// How the images are matched once homologous points lie in one row. Of the options of semi-global matching the local
/// matcher has the limits of left and right, patches and filling; the levels have filling.
struct StereoMatching {
  StereoMatcher matcher = StereoMatcher::kDense;
  StereoOptions dense;
  LocalOptions local;
  LevelOptions levels;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = StereoMatching;
    visit(Field{"matcher", &O::matcher, "", "how disparities are found"});
    visit(Part{&O::dense});
    visit(Group{"local", &O::local});
    visit(Group{"levels", &O::levels});
  }
};

/// Matches two images and writes into `folder`: disparity.tif, sigma.tif (float, NaN: nothing), disparity.png
/// (colours, black: nothing), cloud.ply where the cameras are known, stereo.json; and left.png, right.png when they
/// were resampled. There is no cloud of disparities without sigmas (local matching by rank and census). Errors: neither
/// or both kinds of orientation, images not in it, options of another matcher, geometry, disk.
[[nodiscard]] Result<StereoReport> match_stereo(const std::string& left, const std::string& right,
                                                const std::filesystem::path& folder, const StereoPairOptions& pair,
                                                const StereoMatching& options, const Run& run);

}  // namespace collinea
