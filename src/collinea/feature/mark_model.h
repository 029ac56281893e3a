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

}  // namespace collinea
