// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/dense/level_point.h"
#include "collinea/geometry/delaunay.h"
#include "collinea/geometry/plane_squares.h"

namespace collinea {

/// Disparities that a point may have.
struct DisparityInterval {
  double low_px, high_px;
};

/// Steepest disparities that are looked for: a slope of 45 degrees where the base is half the distance.
constexpr double kSteepest = 0.5;

/// Where points lie in the left image.
[[nodiscard]] std::vector<Eigen::Vector2d> left_positions(std::span<const LevelPoint> points);

/// A surface as disparities of triangles over the left image.
class DisparityModel {
 public:
  /// Error: points that make no triangle.
  static Result<DisparityModel> of(std::span<const LevelPoint> points);

  /// On the plane of the triangle there; nothing outside all of them.
  [[nodiscard]] std::optional<double> at(const Eigen::Vector2d& position) const;

  /// Of that plane, within kSteepest; nothing outside all triangles.
  [[nodiscard]] std::optional<Eigen::Vector2d> gradient_at(const Eigen::Vector2d& position) const;
  /// The point nearest to a position.
  [[nodiscard]] const LevelPoint& nearest(const Eigen::Vector2d& position) const;

  /// What a square round a position holds, and what the triangle there says; the farther away the nearest point, the
  /// more beyond: kSteepest times that distance.
  [[nodiscard]] DisparityInterval around(const Eigen::Vector2d& at, double square_px) const;

 private:
  DisparityModel(std::span<const LevelPoint> points, std::vector<Eigen::Vector2d> positions, Delaunay triangles);
  [[nodiscard]] DisparityInterval interval(const Eigen::Vector2d& at, double half_px) const;

  std::vector<LevelPoint> points_;
  Delaunay triangles_;
  PlaneSquares squares_;
};

}  // namespace collinea
