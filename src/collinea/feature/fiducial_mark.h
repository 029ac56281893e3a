// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/camera/film_calibration.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// The drawing of a fiducial mark as a scan may show it: grey values on a lattice finer than the pixels.
struct MarkTemplate {
  FloatImage values;
  double spacing_px = 1;                  ///< of the lattice
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
/// have one. Drawn at blurs from 0.5 to 3 px.
[[nodiscard]] MarkModel drawn_mark(MarkKind kind, double size_px, double line_px, double inwards_rad);

/// The mark at a position that somebody pointed to, as a template for others like it. Where the pixels are the same
/// turned by 180 degrees about a position nearby, that is the mark (to a tenth of a pixel); else the position itself
/// is. Nothing when the square of `size_px` leaves the scan, or holds one grey value only.
[[nodiscard]] std::optional<MarkModel> learnt_mark(const GreyImage& scan, const Eigen::Vector2d& pointed,
                                                   double size_px);

/// A mark in a scan.
struct FoundMark {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< [px^2]
  double correlation = 0;                                    ///< of drawing and pixels; below zero: dark on bright
};

/// What is known of a mark beforehand: how it is turned against its drawing, and how well; how well its size is known,
/// and its two scales and the angle between them.
struct MarkPrior {
  double rotation_rad = 0, sigma_rotation_rad = 0.03, sigma_scale = 0.03, sigma_affinity = 0.003;
};

/// The mark near a position (to about an eighth of its size), by least squares matching of the drawing onto the pixels:
/// shift, rotation, scale, a little affinity, gain and offset; the blur that fits best. The pixels are not resampled.
/// The covariance is that of neighbours that are correlated as the residuals are (grain, sharpening): N^-1 (sum c(d)
/// J(p)' J(p + d)) N^-1. Nothing when it does not converge, leaves the scan or correlates by less than 0.5.
[[nodiscard]] std::optional<FoundMark> match_mark(const GreyImage& scan, const MarkModel& mark,
                                                  const Eigen::Vector2d& start, const MarkPrior& prior = {});

/// Positions within `radius_px` of the predicted one that look like the mark, best first, `most` at most: correlation
/// at a reduced size, then match_mark().
[[nodiscard]] std::vector<FoundMark> search_mark(const GreyImage& scan, const MarkModel& mark,
                                                 const Eigen::Vector2d& predicted, double radius_px, int most);

}  // namespace collinea
