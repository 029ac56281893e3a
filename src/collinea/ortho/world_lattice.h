// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/geodesy/local_frame.h"
#include "collinea/raster/geotiff.h"

namespace collinea {

/// World coordinates of the cells of a window of a map raster at any height: PROJ at the nodes of a lattice no wider
/// than 50 m, linear between them (error below 1e-4 m).
class WorldLattice {
 public:
  /// The window starts at (column, row) of `grid`, which may lie outside the raster. `frame`: null when map and world
  /// are the same.
  WorldLattice(const LocalFrame* frame, const MapGrid& grid, int column, int row, int width, int height,
               double lowest_m, double highest_m);

  /// x, y: continuous cells of the window.
  [[nodiscard]] Eigen::Vector3d at(double x, double y, double height_m) const;

 private:
  [[nodiscard]] Eigen::Vector3d map_at(double x, double y, double height_m) const {
    return {west_m_ + x * cell_m_, north_m_ - y * cell_m_, height_m};
  }

  bool same_ = true;
  double west_m_, north_m_, cell_m_, lowest_m_, height_range_m_;
  int spacing_ = 32, columns_ = 0, rows_ = 0;
  std::vector<Eigen::Vector3d> low_, high_;
};

}  // namespace collinea
