// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/adjust/adjusted.h"
#include "collinea/quality/internal/measurement.h"

namespace collinea {

/// How far a measurement is from what an adjustment says.
struct Misfit {
  MeasurementIndex index;                         ///< in the block that was given
  Measurement measurement;                        ///< its name
  Eigen::Vector3d off = Eigen::Vector3d::Zero();  ///< given minus adjusted, on the axes of its group [px, m, rad]
  double sigmas = 0;  ///< the length of `off` over the given sigma; infinite: its image does not see the point
};

/// The misfits of all measurements of `given` that can be compared with an adjustment of them with other sigmas, in
/// which some may have had no part: image points of adjusted points in adjusted images, coordinates of control points,
/// positions (of antennas without a shift, a drift or a time offset; else those that took part), geodetic observations
/// and attitudes. The sigmas are those of `given`.
[[nodiscard]] std::vector<Misfit> misfits_of(const Measurements& given, const Adjusted& adjusted);

}  // namespace collinea
