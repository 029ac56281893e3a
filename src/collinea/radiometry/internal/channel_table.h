// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace collinea {

/// Three values, one by channel, at the nodes of a square grid over a plane; bilinear between the nodes, and beyond the
/// grid as at its border.
struct ChannelTable {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  ///< of the first node
  double step = 1;
  int width = 0, height = 0;                 ///< nodes; 0: no table, all values 0
  std::array<std::vector<float>, 3> values;  ///< by channel, rows along x

  /// The four nodes round a position and their weights. Only of tables with two nodes and more each way.
  struct Interpolation {
    std::array<int, 4> node;
    std::array<float, 4> weight;
  };
  [[nodiscard]] Interpolation interpolation_at(const Eigen::Vector2d& at) const;
  [[nodiscard]] std::array<float, 3> at(const Eigen::Vector2d& position) const;

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("origin", &ChannelTable::origin);
    visit("step", &ChannelTable::step);
    visit("width", &ChannelTable::width);
    visit("height", &ChannelTable::height);
    visit("values", &ChannelTable::values);
  }
};

struct ChannelValues {
  Eigen::Vector2d at;
  std::array<float, 3> values;
};

/// The mean of scattered values, smoothed over about `radius`; where there are none, that of the nearest. No table
/// without values. At most 1000 nodes each way: over more, it is smoothed further.
[[nodiscard]] ChannelTable smoothed_table(std::span<const ChannelValues> scattered, double radius);

}  // namespace collinea
