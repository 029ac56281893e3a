// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

#include "collinea/geometry/rigid3.h"
#include "collinea/math/few.h"

namespace collinea {

/// The poses from which three points are seen along three unit rays of the camera frame. The three distance equations
/// are two homogeneous conics; one degenerate member of their pencil (a cubic) gives two lines, hence up to four
/// solutions (Persson and Nordberg, ECCV 2018); the lines are taken from the adjugate instead of an
/// eigen-decomposition, as in Ding et al. (CVPR 2023). Distances are polished by Newton's method. None for points on a
/// line or no three points at all.
[[nodiscard]] Few<Rigid3, 4> p3p(const std::array<Eigen::Vector3d, 3>& rays_in_cam,
                                 const std::array<Eigen::Vector3d, 3>& points_in_world);

}  // namespace collinea
