// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/quality/internal/misfit.h"

namespace collinea {

/// An adjustment that no single measurement bends.
struct RobustFit {
  Measurements measurements;    ///< as given, with the poses and tie points of the fit
  std::vector<Misfit> misfits;  ///< of all of them, in no order that means anything
  Adjusted adjusted;            ///< with the sigmas by which misfits were weighted
};

/// Adjusts so that a gross error of any size in a few measurements says nothing. The loss of Geman and McClure,
///
///     weight (k^2 / (k^2 + d^2))^2 / t^2     of a misfit of d sigmas,
///
/// has a minimum for every subset of measurements that agree with each other, so that the start decides; that is
///
///  1. the free network of images, tie points and marks of control, which no coordinate can bend (mark_network_of());
///  2. moved onto control and positions by that similarity of three of them for which the sum of the roots of all
///     differences in plan and in height is least, which no single difference decides. Where no three are known in all
///     three axes it stays where the given poses are;
///  3. all measurements from there, weighted by their misfits again and again (iteratively reweighted least squares),
///     k being three times t, what is typical of coordinates, of marks and of measurements on the ground (the median,
///     one sigma at least): at first that is how far the free network is bent, in the end their noise.
///
/// Fixed control (sigma 0) is weighted like a coordinate known to one pixel on the ground. Works as long as most
/// coordinates are right, and three points with three right coordinates are among those of control and positions;
/// whether the rest could tell what was wrong is not asked here.
///
/// Cost: three adjustments of the network and up to ten of everything. Errors: those of adjust().
[[nodiscard]] Result<RobustFit> robust_fit(const Measurements& given, const AdjustOptions& options, const Run& run);

/// The misfits of a fit that are gross: beyond twenty sigmas (fifty in images), and as many times what is typical of
/// their kind; the largest first. Where the coordinates contradict each other all of those beyond twenty sigmas.
[[nodiscard]] std::vector<Misfit> gross_misfits(const RobustFit& fit);

/// True when half of the coordinates of control and positions miss the fit by twenty sigmas and more: no few of them
/// are wrong.
[[nodiscard]] bool contradict_each_other(const RobustFit& fit);

}  // namespace collinea
