// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/base/run.h"
#include "collinea/quality/internal/free_network.h"

namespace collinea {

/// How well a point is known from images and cameras as they came out, by rays without error of their own: what
/// everything that is measured in the adjusted images has in common with what lies around it.
struct PointPrecision {
  Eigen::Vector3d position_in_world;
  Eigen::Matrix3d covariance_m2;  ///< by the given sigmas
};

/// At up to 2000 of the tie points with three rays or more, evenly taken; in the datum of all tie points.
[[nodiscard]] std::vector<PointPrecision> point_precisions(const Solved& solved,
                                                           const bundle::FreeNetwork& free_network,
                                                           bundle::TileCholesky& inverse, const Run& run);

}  // namespace collinea
