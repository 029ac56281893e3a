// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <list>
#include <unordered_map>

#include "collinea/surface/height_field.h"

namespace collinea {

/// A surface at a point.
struct SurfaceAt {
  double height_m = std::numeric_limits<double>::quiet_NaN();  ///< nothing there
  double sigma_m = std::numeric_limits<double>::quiet_NaN();   ///< of the cell; NaN: not known
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();             ///< rise to the east and to the north
};

/// Heights at positions in any order, from tiles of a surface of which the last ones stay in memory (some 70 MB). Not
/// for several threads at once.
class SurfaceSampler {
 public:
  explicit SurfaceSampler(const HeightField& field) : field_(field) {}

  /// Bilinear between the middles of four cells, nothing where one of them has no height. The slopes between
  /// the cells too, each Horn's over 3 x 3 cells (Proc. IEEE 69, 1981), where a cell without a height counts as high as
  /// the middle one.
  [[nodiscard]] Result<SurfaceAt> at(const Eigen::Vector2d& on_map);

 private:
  struct Tile {
    int column = 0, row = 0;  ///< of its first cell
    FloatImage heights, sigmas;
  };
  Result<const Tile*> tile_at(int column, int row);

  const HeightField& field_;
  std::list<std::pair<int, Tile>> tiles_;  ///< last used in front
  std::unordered_map<int, std::list<std::pair<int, Tile>>::iterator> position_of_;
};

}  // namespace collinea
