// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/epipolar/model_points.h"
#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/relative_orientation.h"

namespace collinea {

/// A distance measured on the object, between two points of the model.
struct PairDistance {
  int from = 0, to = 0;  ///< indices of points
  double length = 0, sigma = 0;
};

/// A relative orientation with the length of its base.
struct ScaledPair {
  Rigid3 second_from_first;                ///< as the distances leave it: translation of unit length
  double base = 0;                         ///< in the unit of the distances
  Eigen::Matrix<double, 6, 6> covariance;  ///< of changed() and of the base, as stated
  std::vector<double> residuals;           ///< of the distances, adjusted minus measured
  std::vector<double> standardised;        ///< residual over its standard deviation; 0 where nothing checks it
  double redundancy = 0;                   ///< distances less one
  double sigma0 = 0;                       ///< of the distances; 0 without redundancy
  PairModel model;  ///< as model_points(), in the unit of the distances; covariances hold the base's, too
};

/// Relative orientation with scale (Inghilleri; Mussio 3.3.7): distances between points of the model are observations,
/// the base is a sixth unknown. The coplanarity conditions take part through the covariance of the orientation that
/// they gave, which is what they know of it, so that the result is that of one adjustment of all (to first order).
/// `covariances` of the orientation are as stated. Nothing without a distance, between points that have no model
/// coordinates or are one, or where a sigma is not positive.
[[nodiscard]] std::optional<ScaledPair> scaled_pair(const RelativeOrientation& orientation,
                                                    std::span<const PairPoint> points,
                                                    std::span<const PairDistance> distances, bool y_up = false);

}  // namespace collinea
