// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/marking/predicted_marks.h"
#include "collinea/marking/refined_mark.h"
#include "collinea/project/project.h"
#include "collinea/report/marking_report.h"

namespace collinea {

/// Where the oriented images of a project show one of its control points: predicted_marks(), with what its
/// products/dsm.tif hides where there is one. Errors: kNotFound, no point of this name; kIllPosed, the block is not
/// oriented yet.
[[nodiscard]] Result<MarksReport> predict_marks(const Project& project, const std::string& point);

struct TargetOptions {
  std::optional<MarkedKind> kind;

  template <class Visit>
  static void describe(Visit&& visit) {
    visit(
        Field{"kind", &TargetOptions::kind, "", "of the target; nothing: the one that explains the grey values best"});
  }
};

/// The target near a position of an image file (JPEG, PNG, TIFF): tag_near(), where there is none refined_mark().
/// Errors: the file's; a position that is not inside the image; kNotConverged, there is no target.
[[nodiscard]] Result<RefinedMark> target_in_file(const std::filesystem::path& image, const Eigen::Vector2d& near_px,
                                                 const TargetOptions& options);

/// The target near a position of an image of a size, from a window of its file. Errors: as above.
[[nodiscard]] Result<RefinedMark> target_in_image(const std::filesystem::path& image, int width_px, int height_px,
                                                  const Eigen::Vector2d& near_px, std::optional<MarkedKind> kind);

}  // namespace collinea
