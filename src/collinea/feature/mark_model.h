// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <vector>

#include "collinea/camera/film_calibration.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// The drawing of a fiducial mark as a scan may show it: grey values on a lattice finer than the pixels.
struct MarkTemplate {
  FloatImage values;
  double spacing_px = 1;                  ///< of the lattice
  double blur_px = 0;                     ///< standard deviation of light about a point, before pixels gather it
  Eigen::Vector2d centre{0, 0};           ///< of the mark, in pixels of `values`
  [[nodiscard]] double half_px() const {  ///< half the width that it covers
    return spacing_px * 0.5 * std::min(values.width, values.height);
  }
};

/// A mark to be looked for: one drawing at several widths of blur, or one that was learnt.
struct MarkModel {
  std::vector<MarkTemplate> blurred;
};

/// A mark of `size_px` whose lines are `line_px` wide, bright on dark (found the other way round, too). Its axis looks
/// towards `inwards_rad`, from the column towards the row: corner (between its arms) and notch (into the photograph)
/// have one. Drawn as pixels gather it, at blurs from 0.4 to 2.6 px.
[[nodiscard]] MarkModel drawn_mark(MarkKind kind, double size_px, double line_px, double inwards_rad);

/// The mark at a position that somebody pointed to, as a template for others like it. Where the pixels are the same
/// turned by 180 degrees about a position nearby, that is the mark (to a tenth of a pixel); else the position itself
/// is. Nothing when the square of `size_px` leaves the scan, or holds one grey value only.
[[nodiscard]] std::optional<MarkModel> learnt_mark(const GreyImage& scan, const Eigen::Vector2d& pointed,
                                                   double size_px);

}  // namespace collinea
