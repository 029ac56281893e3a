// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/feature/mark_model.h"

namespace collinea {

/// A mark that somebody pointed to, and which of the calibration it is.
struct LearntMark {
  CalibratedMark mark;
  MarkModel model;
  bool is_symmetric = false;  ///< the same turned by 180 degrees
};

/// The mark at a position that somebody pointed to, as a template for others like it. Where the pixels are the same
/// turned by 180 degrees about a position nearby, that is the mark (to a tenth of a pixel); else the position itself
/// is. Nothing when the square of `size_px` leaves the scan, or holds one grey value only. `mark` is left
/// empty.
[[nodiscard]] std::optional<LearntMark> learnt_mark(const GreyImage& scan, const Eigen::Vector2d& pointed,
                                                    double size_px);

/// The likenesses of a mark that lies elsewhere on the film: as it is where it is symmetric; else turned by 0, 90, 180
/// and 270 degrees, and these mirrored.
[[nodiscard]] std::vector<MarkModel> likenesses(const LearntMark& learnt);

}  // namespace collinea
