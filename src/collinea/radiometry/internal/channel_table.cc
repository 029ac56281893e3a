// SPDX-License-Identifier: Apache-2.0
#include "collinea/radiometry/internal/channel_table.h"

#include <algorithm>

namespace collinea {
namespace {

// Sums of weighted values, and of weights, at the nodes.
struct Sums {
  int width, height;
  std::vector<std::array<double, 4>> of;

  [[nodiscard]] std::array<double, 4>& node(int x, int y) {
    return of[std::size_t(y) * std::size_t(width) + std::size_t(x)];
  }
};

// Binomial over three nodes in each direction.
void blur(Sums& sums) {
  const Sums before = sums;
  for (int y = 0; y < sums.height; ++y) {
    for (int x = 0; x < sums.width; ++x) {
      auto& sum = sums.node(x, y);
      sum = {};
      for (int v = std::max(0, y - 1); v <= std::min(sums.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(sums.width - 1, x + 1); ++u)
          for (std::size_t k = 0; k < 4; ++k)
            sum[k] += before.of[std::size_t(v) * std::size_t(sums.width) + std::size_t(u)][k] * (u == x ? 2 : 1) *
                      (v == y ? 2 : 1) / 16;
    }
  }
}

// Sums become means. Nodes without weight take over that of their neighbours, ring by ring.
void to_means(Sums& sums) {
  const auto around = [&](int node, const auto& visit) {
    const int x = node % sums.width, y = node / sums.width;
    for (int v = std::max(0, y - 1); v <= std::min(sums.height - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(sums.width - 1, x + 1); ++u) visit(v * sums.width + u);
  };
  std::vector<int> ring;
  for (int node = 0; node < int(sums.of.size()); ++node) {
    auto& sum = sums.of[std::size_t(node)];
    if (!(sum[3] > 0)) continue;
    for (std::size_t k = 0; k < 4; ++k) sum[k] /= k < 3 ? sum[3] : 1;
    sum[3] = 1;
    ring.push_back(node);
  }
  while (!ring.empty()) {
    std::vector<int> next;
    for (const int node : ring) {
      around(node, [&](int other) {
        if (sums.of[std::size_t(other)][3] > 0) return;
        sums.of[std::size_t(other)][3] = -1;  // waits; nothing is taken over within a ring
        next.push_back(other);
      });
    }
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    for (const int node : next) {
      std::array<double, 4> mean{};
      around(node, [&](int other) {
        const auto& from = sums.of[std::size_t(other)];
        if (!(from[3] > 0)) return;
        for (std::size_t k = 0; k < 4; ++k) mean[k] += from[k];
      });
      for (std::size_t k = 0; k < 3; ++k) sums.of[std::size_t(node)][k] = mean[k] / mean[3];
    }
    for (const int node : next) sums.of[std::size_t(node)][3] = 1;
    ring = std::move(next);
  }
}

}  // namespace

ChannelTable::Interpolation ChannelTable::interpolation_at(const Eigen::Vector2d& at) const {
  const Eigen::Vector2d from = (at - origin) / step;
  const float x = float(std::clamp(from.x(), 0.0, double(width - 1)));
  const float y = float(std::clamp(from.y(), 0.0, double(height - 1)));
  const int i = std::min(int(x), width - 2), j = std::min(int(y), height - 2), node = j * width + i;
  const float u = x - float(i), v = y - float(j);
  return {{node, node + 1, node + width, node + width + 1}, {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v}};
}

std::array<float, 3> ChannelTable::at(const Eigen::Vector2d& position) const {
  std::array<float, 3> result{0, 0, 0};
  if (width == 0) return result;
  const Interpolation between = interpolation_at(position);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t k = 0; k < 4; ++k) result[c] += between.weight[k] * values[c][std::size_t(between.node[k])];
  return result;
}

ChannelTable smoothed_table(std::span<const ChannelValues> scattered, double radius) {
  ChannelTable table;
  if (scattered.empty() || !(radius > 0)) return table;
  Eigen::Vector2d low = scattered[0].at, high = low;
  for (const ChannelValues& one : scattered) low = low.cwiseMin(one.at), high = high.cwiseMax(one.at);
  table.origin = low;
  table.step = std::max(radius, (high - low).maxCoeff() / 998);
  table.width = 2 + int((high - low).x() / table.step), table.height = 2 + int((high - low).y() / table.step);
  const std::size_t nodes = std::size_t(table.width) * std::size_t(table.height);
  Sums sums{table.width, table.height, std::vector<std::array<double, 4>>(nodes)};
  for (const ChannelValues& one : scattered) {
    const ChannelTable::Interpolation position = table.interpolation_at(one.at);
    for (std::size_t k = 0; k < 4; ++k) {
      auto& sum = sums.of[std::size_t(position.node[k])];
      const double weight = double(position.weight[k]);
      for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * double(one.values[c]);
      sum[3] += weight;
    }
  }
  blur(sums);
  to_means(sums);
  for (std::size_t c = 0; c < 3; ++c)
    for (const auto& mean : sums.of) table.values[c].push_back(float(mean[c]));
  return table;
}

}  // namespace collinea
