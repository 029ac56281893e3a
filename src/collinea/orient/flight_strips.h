// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

/// The images of one strip with the time they were taken, from the middle of the strip on [s]; where an image of the
/// block has no time, the number of the image in the strip instead.
using FlightStrip = std::map<ImageId, double>;

/// Cuts the oriented images that have positions into strips, in the order of their times (without these, of their
/// names): a new one begins where the path turns by more than 45 degrees or pauses for more than five times the median
/// interval. What would have fewer than three images stays with the strip before.
[[nodiscard]] std::vector<FlightStrip> flight_strips(const Block& block);

/// All of them as one.
[[nodiscard]] std::vector<FlightStrip> one_strip(const Block& block);

/// How fast each image moved through the world [m/s]: by the parabola through the centres of three images of its strip,
/// the one before and the one after, since strips begin and end with an acceleration. Where all times are whole
/// seconds, by the line through up to five. Empty when an image has no time, or all have the same.
[[nodiscard]] std::map<ImageId, Eigen::Vector3d> flight_velocities(const Block& block);

}  // namespace collinea
