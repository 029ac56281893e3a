// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/relative_elements.h"

namespace collinea {

/// The y-parallax of a point as a linear function of the elements of a nearly normal pair (Mussio 3.2.3, E27), in
/// coordinates of photographs (y up) over the principal distance:
///     y2 - y1 = (x2 - x1) by + (x2 - x1) y bz - (1 + y^2) omega + x2 y phi - x2 kappa,   y = (y1 + y2) / 2, bx = 1
struct ParallaxEquation {
  Vector5 coefficients;  ///< of by, bz, omega, phi, kappa
  double parallax = 0;   ///< y2 - y1 as observed
};
[[nodiscard]] ParallaxEquation parallax_equation(const PairPoint& point);

/// Approximate values of a pair with attitudes alike within some degrees and a base near x, by linear least squares of
/// these equations. Nothing with fewer than five points, or when they leave an element undetermined.
[[nodiscard]] std::optional<DependentElements> linear_parallax(std::span<const PairPoint> points);

/// The simplified orientation of a nearly normal pair: least squares of these equations, each with the variance of its
/// y2 - y1. Nothing is iterated: what the linear equations neglect, products of elements and of a y-parallax with an
/// element, is in the elements as a bias that the covariance does not hold.
struct LinearOrientation {
  DependentElements elements;      ///< bx = 1: of a base towards the left by and bz have the other sign
  Matrix5 covariance;              ///< of values(), for the sigmas as given
  std::vector<double> parallaxes;  ///< residual y-parallaxes, observed minus computed, of each point
  double sigma0 = 0;               ///< 0 without redundancy
  int redundancy = 0;              ///< points less five
};
/// Nothing as linear_parallax().
[[nodiscard]] std::optional<LinearOrientation> linear_orientation(std::span<const PairPoint> points);

/// What an exhaustive search found.
struct RelativeSearch {
  int starts = 0;                ///< 5408: 12,800 sequences of angles (Mussio 3.1.2), those at the poles once (E56)
  int converged = 0;             ///< of them, wherever they went
  std::vector<Rigid3> distinct;  ///< that fit as well as the best one, each once: in general four (3.1.4)
  double rms = 0;                ///< of the best: misclosure of unit rays and a unit base
};
/// Gauss-Newton on the coplanarity of at most 24 of the points, spread over the list, from every 45 degrees of phi1,
/// kappa1, omega2, phi2, kappa2. Needs no idea of the attitudes, but good points. Nothing with fewer than five points.
[[nodiscard]] std::optional<RelativeSearch> search_relative(std::span<const PairPoint> points);

}  // namespace collinea
