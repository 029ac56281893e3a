// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/adjust/solved.h"

namespace collinea {

/// The residual of an image's position, given minus adjusted, and the part of it that residuals before it in the order
/// do not predict, in its own standard deviations. NaN on axes that were not given or of which nothing is left.
struct WhitenedPosition {
  ImageId image;
  Eigen::Vector3d residual_m, whitened;
};

namespace bundle {

/// Residuals of positions made independent, in an order of images. Those of an adjustment depend on each other: they
/// have the covariance C = P^-1 - A Q A'. Each is reduced by its conditional mean given up to 20 before it,
///
///     u = (v - c' C_b^-1 v_b) / sqrt(c0 - c' C_b^-1 c),
///
/// which leaves independent standard normal numbers where errors are normal with the given sigmas (the rows of the
/// inverse Cholesky factor of C, kept to a window as by Vecchia 1988). Where these sigmas are wrong by one factor all u
/// have another size, and are independent all the same. An axis of the world is taken for itself; cofactors outside
/// the selected inverse, of images far apart, count as 0. Images of the order without position are left out.
///
/// Cost: 20 cofactors and a system of 20 for each coordinate. `inverse`: the factor after invert().
[[nodiscard]] std::vector<WhitenedPosition> whitened_positions(const Solved& solved, const std::vector<ImageId>& order,
                                                               TileCholesky& inverse);

}  // namespace bundle
}  // namespace collinea
