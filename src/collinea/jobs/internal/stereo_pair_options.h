// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/dense/depth_map.h"

namespace collinea {

/// What a single pair is matched from.
struct StereoPairOptions {
  std::optional<std::filesystem::path> project, orientation;
  bool rectified = false;
  std::optional<int> min_disparity, max_disparity;
  std::optional<double> focal_px, base_m;
  std::optional<Resolution> resolution;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = StereoPairOptions;
    visit(Field{"project", &O::project, "", "oriented project that holds both photographs, named as there"}.leads_to(
        PathKind::kFolder));
    visit(Field{"orientation", &O::orientation, "",
                "folder with a COLMAP model (text or binary) that holds both photographs; instead of a project"}
              .leads_to(PathKind::kFolder));
    visit(Field{"rectified", &O::rectified, "", "the images are an epipolar pair as they are"});
    visit(Field{"min_disparity", &O::min_disparity, "px",
                "least column left less column right; nothing: 0 for rectified pairs, else from the tie points"});
    visit(Field{"max_disparity", &O::max_disparity, "px",
                "largest; nothing: an eighth of the width for rectified pairs, else from the tie points"});
    visit(Field{"focal_px", &O::focal_px, "px", "of a rectified pair: for coordinates in space", 1, 1e7});
    visit(Field{"base_m", &O::base_m, "m", "distance of the cameras of a rectified pair: for coordinates in space",
                1e-9, 1e9});
    visit(Field{"resolution", &O::resolution, "",
                "size at which the images are matched (nothing: full for rectified pairs, else the largest with at "
                "most 3.2 million pixels)"});
  }
};

}  // namespace collinea
