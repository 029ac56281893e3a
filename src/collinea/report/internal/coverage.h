// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

using Polygon = std::vector<Eigen::Vector2d>;

/// What the images see of the ground, in plan (x east, y north of the world frame).
struct Coverage {
  double ground_height = 0;               ///< median height of the tie points
  std::map<ImageId, Polygon> footprints;  ///< oriented images
};

/// The outlines of the images on the horizontal plane through the median tie point. An image that looks over the
/// horizon, or nearly, gets the convex hull of its tie points instead, without those more than twice as far away as
/// their median.
[[nodiscard]] Coverage coverage_of(const Block& block);

/// How many images see each cell of a raster over all footprints; by footprints, so hills count as flat.
struct Overlap {
  Eigen::Vector2d lower_left = Eigen::Vector2d::Zero();
  double cell = 1;
  int columns = 0, rows = 0;  ///< southern row first
  std::vector<int> images;
  [[nodiscard]] double area(int at_least) const;  ///< of the cells that so many images see
};
[[nodiscard]] Overlap overlap_of(const Coverage& coverage, int longest_side_cells);

}  // namespace collinea
