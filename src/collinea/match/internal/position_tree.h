// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace collinea {

/// Nearest points of a set in space: a k-d tree (Bentley 1975). Made in O(n log n), asked in about O(k log n).
class PositionTree {
 public:
  struct Neighbour {
    double squared_distance;
    std::uint32_t index;  ///< into the points it was made from
    friend auto operator<=>(const Neighbour&, const Neighbour&) = default;
  };

  explicit PositionTree(std::vector<Eigen::Vector3d> points);

  /// The `count` points nearest to point `index`, without itself, nearest first; of equally near ones those with the
  /// smaller index.
  [[nodiscard]] std::vector<Neighbour> nearest(std::uint32_t index, std::size_t count) const;

 private:
  void build(std::size_t begin, std::size_t end);
  void search(std::size_t begin, std::size_t end, std::uint32_t index, std::size_t count,
              std::vector<Neighbour>& heap) const;

  std::vector<Eigen::Vector3d> points_;
  std::vector<std::uint32_t> order_;  // the middle of every range parts it along axis_
  std::vector<std::uint8_t> axis_;
};

}  // namespace collinea
