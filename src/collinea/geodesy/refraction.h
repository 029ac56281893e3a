// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// By how much the image of a point appears farther from the nadir than it is, over the tangent of its angle from the
/// nadir [rad]: Saastamoinen (1972) for the standard atmosphere, over layers parallel to the ground. Heights of camera
/// and point above the sea; the same for both ways round, 0 for equal heights.
[[nodiscard]] double refraction_rad(double camera_height_m, double point_height_m);

}  // namespace collinea
