// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <map>
#include <optional>

#include "collinea/adjust/bundle.h"
#include "collinea/block/block.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {

/// The datum of a single strip: positions on one line fix location, scale and direction, but not the rotation about the
/// line; that comes from the attitudes the camera wrote. Good to about a degree across the line. Nothing when fewer
/// than half of the images have an attitude, when these contradict each other, when the positions (root mean square
/// distance from their middle) do not reach over ten times their standard deviation, or when the line through them,
/// their longest axis, is steep. Every position counts by its own standard deviation.
[[nodiscard]] std::optional<Similarity3> strip_datum(const Block& block);

/// What the attitudes of the cameras say of the vertical, as observations for the adjustment. Mounting and gimbal err
/// in all images alike: the mean of all is good to a degree, however many there are.
[[nodiscard]] std::map<ImageId, GivenVertical> verticals_by_attitude(const Block& block);

/// How well the positions of the images fix the turn of the block about the line through them: standard deviation
/// [rad]; each counts by its own. The stations count as they lie in the block, so that the errors of the positions do
/// not look like a width.
/// Infinite with fewer than three positions.
[[nodiscard]] double rotation_sigma_rad(const Block& block, double world_per_block);

}  // namespace collinea
