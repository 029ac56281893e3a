// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "collinea/geometry/plane.h"
#include "collinea/project/product_frame.h"
#include "collinea/project/project.h"

namespace collinea {

/// What says which plane of an oriented project is meant: one of the three.
struct AskedPlane {
  std::optional<std::string> control;               ///< names of surveyed points, separated by commas
  std::optional<std::filesystem::path> map_points;  ///< file with easting, northing, height in each line
  std::optional<std::string> region;                ///< west,south,east,north[,lowest,highest] of a part of the cloud
  std::optional<double> tolerance_m;  ///< with region: largest distance of its points; nothing: 3 median sigmas
};

/// A plane of a project as it is drawn: its front is the side from which the images see it, the lower left corner
/// of its points the origin.
struct ProjectPlane {
  FramedPlane frame;
  std::size_t points = 0, of = 0;  ///< on the plane, of those looked at
  double rms_m = 0;                ///< of their distances from it
  Eigen::Vector2d extent;          ///< upper right corner of the points but one in a hundred on each side, metres
};

/// Errors: not one of the three asked for, unreadable, unknown points, too few, on a line, no plane in the region.
[[nodiscard]] Result<ProjectPlane> plane_of_project(const Project& project, const Block& block,
                                                    const ProductFrame& product_frame, const AskedPlane& asked);

}  // namespace collinea
