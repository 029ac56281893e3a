// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/relative_elements.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// The coplanarity condition of a point for a pair whose orientation is given. Rays are (x, y, -1), in units of the
/// principal distance. The three values differ by the length of the base alone: dependent = symmetric / |bx of the unit
/// base|, exterior = symmetric * base.
struct PointCoplanarity {
  std::optional<double> dependent;  ///< bx = +-1; nothing for a base across x
  double symmetric = 0;             ///< base of unit length
  double exterior = 0;              ///< base as the projection centres have it, in their unit
  double sigma = 0;                 ///< of symmetric: by the measurements and by the elements
  double gap = 0;  ///< shortest change of the four coordinates that makes the rays meet, with the sign of symmetric
  double w = 0;    ///< symmetric over its sigma
};

struct GivenCoplanarity {
  std::vector<PointCoplanarity> points;
  /// Root of C' S^-1 C / n with the covariance S of all conditions, in which the elements make them correlated: of
  /// right elements and sigmas n sigma0^2 is chi-squared with n degrees of freedom.
  double sigma0 = 0;
};

/// Each form by its own elements: dependent and symmetric ones of the motion, attitudes and projection centres of the
/// poses. `covariance` is of changed(); zero: elements without error. Nothing is estimated and nothing rejected.
[[nodiscard]] GivenCoplanarity given_coplanarity(std::span<const PairPoint> points,
                                                 const std::array<Rigid3, 2>& cam_from_world,
                                                 const Matrix5& covariance);

}  // namespace collinea
