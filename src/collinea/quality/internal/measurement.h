// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <set>
#include <span>
#include <variant>

#include "collinea/adjust/bundle.h"
#include "collinea/adjust/observation_group.h"
#include "collinea/block/block.h"

namespace collinea {

// Measurements as data snooping treats them: what goes as one is an image point (both coordinates), the plan or the
// height of a control point or of a position, a geodetic observation, the level or the heading of an attitude. Where
// the values of a group are kept (ObservationSource) decides how its measurements are named, rejected, compared and
// restored; this unit is the only one of data snooping that knows.

/// Names a measurement by what it is of, which stays the same when others are rejected (indices in a block do not). Two
/// marks of one point in one image have the same name.
struct Measurement {
  ObservationGroup group{};
  ImageId image;               ///< of image points, positions and attitudes
  PointId point;               ///< of image points of tie points
  ControlId control;           ///< of image points and coordinates of control
  std::uint32_t geodetic = 0;  ///< of geodetic observations: index in Block::geodetic

  friend auto operator<=>(const Measurement&, const Measurement&) = default;
};

/// Where a measurement stands in a block: `source` as in TestedObservation.
struct MeasurementIndex {
  ObservationGroup group{};
  std::uint32_t source = 0;
};

/// All that an adjustment is given: the block, and in the scope the attitudes.
struct Measurements {
  Block block;
  AdjustScope scope;
};

/// What restores a rejected measurement: an image point as it was, or the sigmas of coordinates and attitudes [m, rad].
/// Geodetic observations need nothing.
using GivenMeasurement = std::variant<std::monostate, Observation, ControlObservation, Eigen::Vector3d>;

/// The coordinates of a vector that are of a group (ObservationGroupTraits::first_axis).
[[nodiscard]] inline auto axes_of(ObservationGroup group, Eigen::Vector3d& all) {
  return all.segment(traits_of(group).first_axis, traits_of(group).axes);
}
[[nodiscard]] inline auto axes_of(ObservationGroup group, const Eigen::Vector3d& all) {
  return all.segment(traits_of(group).first_axis, traits_of(group).axes);
}

[[nodiscard]] Measurement measurement_at(MeasurementIndex index, const Block& block);

/// Control points that a coordinate or a geodetic observation is of; none of other measurements.
[[nodiscard]] std::set<ControlId> control_points_of(const Measurement& measurement, const Block& block);

/// The measurement as it is given now, which restores it later.
[[nodiscard]] GivenMeasurement given_at(MeasurementIndex index, const Measurements& all);

/// The measurements without some of them. Image points are removed; coordinates and attitudes get infinite sigmas on
/// the axes of their group; geodetic observations become check observations, which are only compared.
[[nodiscard]] Measurements without(Measurements all, std::span<const MeasurementIndex> rejected);

/// The measurements with one that was rejected, as it was given. Tie points stay sorted by (point, image).
[[nodiscard]] Measurements with(Measurements all, const Measurement& measurement, const GivenMeasurement& given);

/// A rejected measurement minus what an adjustment without it says, in the frame in which it is given [px, m, rad]:
/// this is the best estimate of its gross error, since nothing of it is left in the adjusted values. Only the axes of
/// its group have a meaning. Nothing when it cannot be compared: the image does not see the point, the point is not
/// determined, or a lever arm or a track lies between position and camera. `left`: with the adjusted values.
[[nodiscard]] std::optional<Eigen::Vector3d> misclosure(const Measurement& measurement, const GivenMeasurement& given,
                                                        const Measurements& left, const Adjusted& adjusted);

/// The standard deviation of the misclosure of one coordinate of a control point whose coordinates are correlated. Its
/// test was that beside the other coordinates, which have gone with it, so that its cofactor there says nothing:
/// sigma^2 + sigma0^2 q with the variance q of the adjusted coordinate. Nothing for all other measurements.
[[nodiscard]] std::optional<double> sigma_of_correlated(const Measurement& measurement, const GivenMeasurement& given,
                                                        int axis, double sigma0, const Measurements& left,
                                                        const Adjusted& adjusted);

}  // namespace collinea
