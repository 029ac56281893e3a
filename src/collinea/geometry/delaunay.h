// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace collinea {

/// The Delaunay triangulation of points of the plane: no point lies within the circle through the corners of a
/// triangle. Points are put in one after another, in the order of a curve that keeps neighbours together (Bowyer 1981;
/// Watson 1981), with the space outside as triangles with a corner at infinity. All decisions are exact: points are
/// moved to a lattice of 2^26 steps over their extent beforehand (15 um in a kilometre). Some two microseconds a point.
class Delaunay {
 public:
  struct Triangle {
    std::array<int, 3> corners;     ///< indices of points, counter-clockwise
    std::array<int, 3> neighbours;  ///< of triangles, each across from its corner; -1: outside
  };

  /// Nothing with fewer than three points, when all lie on a line, or when one is not finite. Of points on one place
  /// the first one takes part.
  static std::optional<Delaunay> of(std::span<const Eigen::Vector2d> points);

  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }

  /// A position within a triangle: weights of its corners, which sum up to 1.
  struct Location {
    int triangle = 0;
    std::array<double, 3> weights{};
  };
  /// Walks from a triangle nearby. Nothing outside all triangles.
  [[nodiscard]] std::optional<Location> find(const Eigen::Vector2d& position) const;

 private:
  [[nodiscard]] std::optional<Location> walk(const Eigen::Vector2d& position, int triangle) const;
  [[nodiscard]] std::size_t square_of(const Eigen::Vector2d& position) const;

  std::vector<Eigen::Vector2d> points_;
  std::vector<Triangle> triangles_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero(), square_ = low_;  // of the grid of starts
  int squares_ = 1;                                                // across and down
  std::vector<int> start_;                                         // a triangle in or near each square
};

}  // namespace collinea
