// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/camera/film_calibration.h"
#include "collinea/camera/film_transformation.h"
#include "collinea/feature/fiducial_mark.h"
#include "collinea/feature/learnt_mark.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Where a scan of that size shows the film: its middle in the middle of the scan, turned by quarters from the column
/// towards the row. A given size of a pixel is used, else the film fills the scan.
[[nodiscard]] FilmTransformation predicted_scan(const FilmCalibration& calibration, int width_px, int height_px,
                                                std::optional<double> pixel_mm, int quarter_turns);

struct FiducialSearch {
  FilmTransformation predicted;
  double radius_mm = 4;              ///< round the predicted positions
  MarkKind kind = MarkKind::kCross;  ///< of marks of which the calibration states none
  /// Instead of drawings, for marks of the kind that the calibration states of these, or of none where it states none.
  std::vector<LearntMark> learnt = {};
};

struct FoundFiducial {
  std::string name;
  FoundMark mark;
};

/// The marks of a calibration in a scan, each at one of the positions about the predicted one that look like it: those
/// that lie together as the calibration says (a similarity of two of them, turned by up to 5 degrees and scaled by up
/// to 5 % from the prediction, within 0.2 mm of it). Marks that only one such position would join are not among them;
/// empty when fewer than three agree.
[[nodiscard]] std::vector<FoundFiducial> find_fiducials(const GreyImage& scan, const FilmCalibration& calibration,
                                                        const FiducialSearch& search, const Run& run);

}  // namespace collinea
