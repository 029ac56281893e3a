// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "collinea/surface/height_point.h"

namespace collinea {

/// Points sorted into squares, to find those nearest to a position.
class NearestPoints {
 public:
  explicit NearestPoints(std::span<const HeightPoint> points);

  /// The `count` nearest in plan, nearest first, by their indices; all when there are fewer.
  [[nodiscard]] std::vector<std::size_t> around(const Eigen::Vector2d& on_map, std::size_t count) const;
  [[nodiscard]] const std::vector<HeightPoint>& points() const { return points_; }

 private:
  [[nodiscard]] std::pair<int, int> square_of(const Eigen::Vector2d& on_map) const;

  std::vector<HeightPoint> points_;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();
  double side_m_ = 1;
  int across_ = 1, down_ = 1;
  std::vector<std::size_t> begin_, order_;  // points of a square: order_[begin_[s]] to order_[begin_[s + 1]]
};

}  // namespace collinea
