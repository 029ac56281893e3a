// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/dense/level_point.h"
#include "collinea/geometry/delaunay.h"

namespace collinea {

/// Disparities that a point may have.
struct DisparityInterval {
  double low_px, high_px;
};

/// Points of a surface sorted into squares of the left image.
class DisparityNeighbours {
 public:
  explicit DisparityNeighbours(std::span<const LevelPoint> points);

  /// Disparities of the points nearest to point i, with its own.
  [[nodiscard]] std::vector<double> disparities(std::size_t i, std::size_t count) const;
  /// The smallest and largest within half_px of a position in column and row, of at least `least` points: the square
  /// grows until there are so many.
  [[nodiscard]] DisparityInterval interval(const Eigen::Vector2d& at, double half_px, std::size_t least) const;

 private:
  // Calls visit(index) for points of squares that touch the square round a position.
  template <class Visit>
  void in_square(const Eigen::Vector2d& at, double half_px, const Visit& visit) const;

  std::vector<LevelPoint> points_;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();
  double side_px_ = 1, extent_px_ = 1;
  int across_ = 1, down_ = 1;
  std::vector<std::size_t> begin_, order_;
};

/// A surface as disparities of triangles over the left image.
class DisparityModel {
 public:
  /// Error: points that make no triangle.
  static Result<DisparityModel> of(std::span<const LevelPoint> points);

  /// What a square round a position holds, and what the triangle there says.
  [[nodiscard]] DisparityInterval around(const Eigen::Vector2d& at, double square_px) const;

 private:
  DisparityModel(std::span<const LevelPoint> points, Delaunay triangles);

  std::vector<LevelPoint> points_;
  Delaunay triangles_;
  DisparityNeighbours neighbours_;
};

}  // namespace collinea
