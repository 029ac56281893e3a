// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// Squared distance [px^2] of pair i from the nearest pair that obeys (x2, y2, 1) M (x1, y1, 1)' = 0, to first order
/// (Sampson), both images measured equally well: chi-squared with one degree of freedom for unit noise. M is
/// essential or fundamental, of any scale. `out` has end - begin values.
void squared_epipolar_errors(const Eigen::Matrix3d& matrix, const PointPairs& pairs, int begin, int end, double* out);

/// A relative orientation and how well it fits.
struct RelativeFit {
  Rigid3 second_from_first;  ///< translation of unit length
  double rms_px = 0;         ///< of the Sampson distances, each capped at loss_px
  Eigen::Matrix<double, 5, 5>
      covariance;  ///< of [rotation (rad, in second), translation along its two tangents] for unit noise [1/px^2]
};

/// The motion that minimises the Sampson distances of the pairs `support`, each capped smoothly at loss_px
/// (Geman-McClure), over its five degrees of freedom by damped Gauss-Newton from `start`. Nothing with fewer than five
/// pairs or when they leave a degree of freedom undetermined.
[[nodiscard]] std::optional<RelativeFit> refine_relative(const Rigid3& start, const PointPairs& pairs,
                                                         std::span<const int> support, double loss_px);

/// The motion with the least sum of absolute Sampson distances of all pairs, by iteratively reweighted least squares
/// from `start` (weights 1 / |r|, rounded off within 0.001 px). A local minimum. Nothing as above.
[[nodiscard]] std::optional<Rigid3> refine_relative_absolute(const Rigid3& start, const PointPairs& pairs);

/// Which focal lengths are off by one common, unknown factor, and how far (standard deviation of its logarithm).
struct FocalDoubt {
  bool first = true, second = true;
  double sigma = 0.1;
};

/// A relative orientation together with the factor by which the doubtful focal lengths must be multiplied.
struct RelativeFocalFit {
  Rigid3 second_from_first;  ///< of the coordinates after correction: divided by the factor where the focal length is
                             ///< in doubt
  double focal_factor = 1;
};

/// refine_relative with the focal factor as sixth unknown, held near 1 by its standard deviation (against residuals of
/// about 1 px). Nothing with fewer than six pairs.
[[nodiscard]] std::optional<RelativeFocalFit> refine_relative_and_focal(const Rigid3& start, const PointPairs& pairs,
                                                                        std::span<const int> support, double loss_px,
                                                                        const FocalDoubt& doubt);

/// refine_relative for a matrix of rank 2 (seven degrees of freedom: two orthonormal frames and the ratio of the
/// singular values, after Bartoli and Sturm, PAMI 2004). The answer has norm 1. Nothing with fewer than seven pairs.
[[nodiscard]] std::optional<Eigen::Matrix3d> refine_fundamental(const Eigen::Matrix3d& start, const PointPairs& pairs,
                                                                std::span<const int> support, double loss_px);

}  // namespace collinea
