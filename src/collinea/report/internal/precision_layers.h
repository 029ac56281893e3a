// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/report/internal/adjustment_products.h"
#include "collinea/vector/vector_layer.h"

namespace collinea {

/// The standard error ellipse of a position in plan.
struct ErrorEllipse {
  double semi_major_m = 0, semi_minor_m = 0;
  double azimuth_deg = 0;  ///< of the major axis: from grid north to the east, in [0, 180)
};
/// `covariance_m2`: of east and north. Not finite where that is not.
[[nodiscard]] ErrorEllipse error_ellipse(const Eigen::Matrix2d& covariance_m2);

/// The outline of the ellipse that holds the position with probability 0.95 (2.448 times the standard one, of the
/// normal distribution in two dimensions), drawn `times` larger.
[[nodiscard]] std::vector<Eigen::Vector3d> ellipse_outline(const Eigen::Vector3d& centre_m, const ErrorEllipse& ellipse,
                                                           double times);

/// What maps show of an adjustment, as layers with styles for QGIS:
///   - error_ellipses: those of control, images and up to 2000 tie points, evenly taken, as polygons; `times` enlarged
///   - residuals: differences of control, check points and positions of images in plan, as lines from where the point
///     lies to where its given coordinates are; enlarged likewise, by a factor of their own
/// Both factors are round numbers (1, 2 or 5 by a power of ten) that make the median a thirtieth of what the block
/// measures across, and stand in every row and in the description of the layer. A layer without a row is left out.
[[nodiscard]] std::vector<VectorLayer> precision_layers(const AdjustmentReport& report,
                                                        const AdjustmentProducts& products);

}  // namespace collinea
