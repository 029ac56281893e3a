// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace collinea {

/// Points of the plane sorted into squares, some four of them in each, to find those near a position. From several
/// threads at once.
class PlaneSquares {
 public:
  explicit PlaneSquares(std::vector<Eigen::Vector2d> points);

  /// Indices of the `count` points nearest to a position, nearest first (of equal ones the lower index); fewer when no
  /// more lie within a distance.
  [[nodiscard]] std::vector<std::size_t> nearest(const Eigen::Vector2d& at, std::size_t count,
                                                 double within = std::numeric_limits<double>::infinity()) const;

  /// Calls visit(index) for the points that differ from a position by at most `half` in x and in y.
  template <class Visit>
  void in_square(const Eigen::Vector2d& at, double half, const Visit& visit) const {
    const Eigen::Vector2d from = (at - corner_) / side_, reach = Eigen::Vector2d::Constant(half / side_);
    const auto limited = [](double value, int count) { return int(std::clamp(std::floor(value), 0.0, count - 1.0)); };
    const Eigen::Vector2d low = from - reach, high = from + reach;
    for (int y = limited(low.y(), down_); y <= limited(high.y(), down_); ++y)
      for (int x = limited(low.x(), across_); x <= limited(high.x(), across_); ++x) {
        const std::size_t s = std::size_t(y) * std::size_t(across_) + std::size_t(x);
        for (std::size_t i = begin_[s]; i < begin_[s + 1]; ++i)
          if ((points_[order_[i]] - at).cwiseAbs().maxCoeff() <= half) visit(order_[i]);
      }
  }

  [[nodiscard]] std::size_t size() const { return points_.size(); }

 private:
  std::vector<Eigen::Vector2d> points_;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();
  double side_ = 1;
  int across_ = 1, down_ = 1;
  std::vector<std::size_t> begin_, order_;  // points of a square: order_[begin_[s]] to order_[begin_[s + 1]]
};

}  // namespace collinea
