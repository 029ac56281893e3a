// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace collinea {

/// A terrain: heights at the nodes of a square grid, bilinear between them. The bilinear surface is the truth itself,
/// not an approximation of one, so rays meet it in closed form.
class Heightfield {
 public:
  /// `width` x `height` nodes, `cell_m` apart, the first at (west_m, south_m); rows go north. heights_m row by row.
  /// At least 2 x 2 nodes.
  Heightfield(double west_m, double south_m, double cell_m, int width, int height, std::vector<float> heights_m);

  /// The height at a position; outside the grid that of the nearest position inside.
  [[nodiscard]] double height(double x, double y) const;
  /// The upward unit normal at a position inside.
  [[nodiscard]] Eigen::Vector3d normal(double x, double y) const;

  /// The first parameter t in [start, end] where origin + t direction is on or below the surface; the part of the line
  /// between must lie over the grid.
  [[nodiscard]] std::optional<double> meet(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                           double start, double end) const;

  /// The highest node of the cells [column, column + count) x [row, row + count), clipped to the grid.
  [[nodiscard]] double highest(int column, int row, int count) const;

  [[nodiscard]] double west_m() const { return west_m_; }
  [[nodiscard]] double south_m() const { return south_m_; }
  [[nodiscard]] double east_m() const { return west_m_ + cells_x() * cell_m_; }
  [[nodiscard]] double north_m() const { return south_m_ + cells_y() * cell_m_; }
  [[nodiscard]] double cell_m() const { return cell_m_; }
  [[nodiscard]] int cells_x() const { return width_ - 1; }
  [[nodiscard]] int cells_y() const { return height_ - 1; }
  [[nodiscard]] double lowest_m() const { return lowest_m_; }
  [[nodiscard]] double highest_m() const { return highest_m_; }

 private:
  struct Patch;
  [[nodiscard]] Patch patch(int column, int row) const;
  [[nodiscard]] Patch patch_at(double x, double y, double& u, double& v) const;

  double west_m_, south_m_, cell_m_, lowest_m_ = 0, highest_m_ = 0;
  int width_, height_;
  std::vector<float> heights_m_;
};

}  // namespace collinea
