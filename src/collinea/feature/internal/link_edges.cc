// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/link_edges.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace collinea {
namespace {

constexpr std::int32_t kNone = -1;
constexpr double kLeastCosine = 0.5;  // between the normals of neighbours
constexpr double kSamePx = 0.25;      // between two findings of one point
constexpr double kGapPx = 2.0;        // between the ends of a chain that is closed

class Linker {
 public:
  Linker(const std::vector<PixelEdge>& found, int width, int height)
      : found_(found), index_(width, height, 1, kNone), free_(found.size(), 0) {
    for (std::size_t i = 0; i < found.size(); ++i) index_.at(found[i].x, found[i].y) = std::int32_t(i);
  }

  // Marks as free what hangs together with a strong point.
  void release_above(double high) {
    std::vector<std::size_t> open;
    const auto release = [&](std::size_t i) {
      if (free_[i]) return;
      free_[i] = 1;
      open.push_back(i);
    };
    for (std::size_t i = 0; i < found_.size(); ++i)
      if (found_[i].point.amplitude >= high) release(i);
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      for_each_neighbour(i, release);
    }
  }

  // The chain through a free point, whose points are free no more.
  std::vector<std::size_t> chain_through(std::size_t start) {
    free_[start] = 0;
    std::vector<std::size_t> chain;
    follow(start, -1, chain);
    std::reverse(chain.begin(), chain.end());
    chain.push_back(start);
    follow(start, +1, chain);
    return chain;
  }
  [[nodiscard]] bool is_free(std::size_t i) const { return free_[i] != 0; }

 private:
  template <class Act>
  void for_each_neighbour(std::size_t i, const Act& act) const {
    const PixelEdge& p = found_[i];
    for (int y = std::max(0, p.y - 1); y <= std::min(index_.height - 1, p.y + 1); ++y)
      for (int x = std::max(0, p.x - 1); x <= std::min(index_.width - 1, p.x + 1); ++x)
        if (const std::int32_t n = index_.at(x, y); n != kNone && std::size_t(n) != i) act(std::size_t(n));
  }

  void follow(std::size_t from, int sense, std::vector<std::size_t>& chain) {
    std::optional<std::size_t> next = neighbour_along(from, sense);
    while (next) {
      chain.push_back(*next);
      next = neighbour_along(*next, sense);
    }
  }

  // The nearest free neighbour in the direction of the edge, which is free no more; `sense` +1: brighter on the left.
  // What lies at the same position is the same point, found from two pixels, and dropped.
  std::optional<std::size_t> neighbour_along(std::size_t i, int sense) {
    const EdgePoint& from = found_[i].point;
    const Eigen::Vector2d tangent = sense * Eigen::Vector2d(-from.normal.y(), from.normal.x());
    std::optional<std::size_t> best;
    double best_px = 3;
    for_each_neighbour(i, [&](std::size_t n) {
      const EdgePoint& to = found_[n].point;
      if (!free_[n] || from.normal.dot(to.normal) < kLeastCosine) return;
      const Eigen::Vector2d step = to.at - from.at;
      const double length = step.norm();
      if (length < kSamePx) free_[n] = 0;
      if (length < kSamePx || step.dot(tangent) < 0.5 * length || length >= best_px) return;
      best_px = length;
      best = n;
    });
    if (best) free_[*best] = 0;
    return best;
  }

  const std::vector<PixelEdge>& found_;
  Raster<std::int32_t> index_;
  std::vector<char> free_;
};

bool closes(const std::vector<PixelEdge>& found, const std::vector<std::size_t>& chain) {
  return chain.size() >= 8 && (found[chain.front()].point.at - found[chain.back()].point.at).norm() < kGapPx;
}

}  // namespace

void link_edges(const std::vector<PixelEdge>& found, int width, int height, double high, std::size_t shortest,
                EdgeMap& map) {
  Linker linker(found, width, height);
  linker.release_above(high);
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!linker.is_free(i)) continue;
    const std::vector<std::size_t> chain = linker.chain_through(i);
    if (chain.size() < shortest) continue;
    map.chains.push_back({map.points.size(), chain.size(), closes(found, chain)});
    for (const std::size_t k : chain) map.points.push_back(found[k].point);
  }
}

}  // namespace collinea
