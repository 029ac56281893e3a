// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace collinea {

/// Corresponding image points of two pictures: undistorted image coordinates (X/Z, Y/Z) of pair i in x1[i], y1[i]
/// (first) and x2[i], y2[i] (second). The focal lengths turn distances between them into pixels.
struct PointPairs {
  std::vector<double> x1, y1, x2, y2;
  double focal_first_px = 1, focal_second_px = 1;

  [[nodiscard]] int size() const { return static_cast<int>(x1.size()); }
  [[nodiscard]] Eigen::Vector2d first(int i) const {
    const auto k = static_cast<std::size_t>(i);
    return {x1[k], y1[k]};
  }
  [[nodiscard]] Eigen::Vector2d second(int i) const {
    const auto k = static_cast<std::size_t>(i);
    return {x2[k], y2[k]};
  }
  void reserve(std::size_t count) {
    for (auto* values : {&x1, &y1, &x2, &y2}) values->reserve(count);
  }
  void add(const Eigen::Vector2d& in_first, const Eigen::Vector2d& in_second) {
    x1.push_back(in_first.x());
    y1.push_back(in_first.y());
    x2.push_back(in_second.x());
    y2.push_back(in_second.y());
  }
};

}  // namespace collinea
