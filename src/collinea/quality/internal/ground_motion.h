// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/adjust/block_motion.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {

/// How well the ground is known as a whole: the motion that fits the errors of its points best, and what is known of
/// it.
///
/// Model. A point at X in error by e (estimated minus true) is moved by g(X) t + rest, t = [shift / size, angles (rad)
/// about x, y, z of the world, log scale] and g = size * motion_of(). The best t is T = (sum w g'g)^-1 sum w g' e: the
/// seven parameters of a Helmert transformation from the true to the estimated ground. Its covariance follows from the
/// linear dependence of e on the reduced unknowns and on the rays of each point.
///
/// Why points and not images: projection centres go with the tilts of their images (an image that moves sideways and
/// looks back shows nearly the same), so that a motion fitted to centres is mostly noise of these, however well the
/// ground is held. Nobody measures in the centres.
///
/// Weights are 1, but less for points whose own rays fix them worse than those of the median point: by the ratio of
/// their variances. A point far behind the object has a distance that says nothing of the whole.
///
/// Datum. Motions that nothing observes have no covariance; they are removed (S-transformation to the datum of these
/// very points), so that their variance is 0.
struct GroundMotion {
  struct Point {
    std::size_t number;  ///< in Problem::points
    double weight;
  };
  std::vector<Point> points;  ///< tie and control points, evenly taken; up to 2000
  Eigen::Vector3d centre;     ///< of these, weighted [m]
  double size = 1;            ///< root mean square distance of these from the centre, weighted [m]
  Matrix7 observed;    ///< removes the motions that nothing observes from T; the unit matrix where there are none
  Matrix7 covariance;  ///< of T without them, by the given sigmas

  /// T of given errors, parallel to `points` [m], without the motions that nothing observes.
  [[nodiscard]] Vector7 fitted_to(const State& state, const std::vector<Eigen::Vector3d>& errors) const;
};

/// Nothing where the points do not tell all seven motions: fewer than three, or all on a line. Of a block of one part.
/// `factor`: of the reduced normal equations; seven solutions.
[[nodiscard]] std::optional<GroundMotion> ground_motion(const Problem& problem, const State& state,
                                                        const TileCholesky& factor);

}  // namespace collinea::bundle
