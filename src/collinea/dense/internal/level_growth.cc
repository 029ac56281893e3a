// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/level_growth.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <optional>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/disparity_model.h"
#include "collinea/dense/internal/shaped_window.h"

namespace collinea {
namespace {

constexpr double kNear_px = 2;                         // of a neighbour's plane
constexpr double kSame_px = 0.5, kSameGradient = 0.1;  // planes that lead to the same match
constexpr std::size_t kNearest = 6;                    // points of a model
constexpr double kFarthest_px = 100;                   // of them: gradients known to 0.02 lead astray by kNear_px there
constexpr std::size_t kBlock = 64;                     // pixels of a piece of work

// Where matches of a grid lie: for each node a point, a pixel that has none, or nothing.
class GrownGrid {
 public:
  GrownGrid(const GreyImage& image, std::span<const Eigen::Vector2i> pixels, std::span<const LevelPoint> points,
            int step_px)
      : step_(step_px), across_(image.width / step_px + 1), down_(image.height / step_px + 1) {
    nodes_.assign(std::size_t(across_) * std::size_t(down_), kNothing);
    for (std::size_t i = 0; i < pixels.size(); ++i) nodes_[node_of(pixels[i])] = kFirstUnmatched - std::int32_t(i);
    for (std::size_t i = 0; i < points.size(); ++i) set(points[i].left_px.cast<int>(), i);
  }

  void set(const Eigen::Vector2i& pixel, std::size_t point) { nodes_[node_of(pixel)] = std::int32_t(point); }

  // Indices of pixels without a match that are neighbours of the points from the index `first` on, in their order.
  [[nodiscard]] std::vector<std::size_t> unmatched_near(std::span<const LevelPoint> points, std::size_t first) const {
    std::vector<std::size_t> found;
    for (const LevelPoint& point : points.subspan(first))
      around(point.left_px.cast<int>(), [&](std::int32_t node) {
        if (node <= kFirstUnmatched) found.push_back(std::size_t(kFirstUnmatched - node));
      });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  // Points of the eight neighbours from the index `first` on.
  void neighbours(const Eigen::Vector2i& pixel, std::size_t first, std::vector<std::size_t>& found) const {
    found.clear();
    around(pixel, [&](std::int32_t node) {
      if (node >= 0 && std::size_t(node) >= first) found.push_back(std::size_t(node));
    });
  }

 private:
  static constexpr std::int32_t kNothing = -1, kFirstUnmatched = -2;

  // The nodes round a pixel and its own, row by row.
  template <class Visit>
  void around(const Eigen::Vector2i& pixel, const Visit& visit) const {
    const int x = pixel.x() / step_, y = pixel.y() / step_;
    for (int v = std::max(y - 1, 0); v <= std::min(y + 1, down_ - 1); ++v)
      for (int u = std::max(x - 1, 0); u <= std::min(x + 1, across_ - 1); ++u)
        visit(nodes_[std::size_t(v) * std::size_t(across_) + std::size_t(u)]);
  }

  [[nodiscard]] std::size_t node_of(const Eigen::Vector2i& pixel) const {
    return std::size_t(pixel.y() / step_) * std::size_t(across_) + std::size_t(pixel.x() / step_);
  }

  int step_, across_, down_;
  std::vector<std::int32_t> nodes_;
};

// A plane at a pixel.
struct Prediction {
  double disparity_px;
  Eigen::Vector2d gradient;
};

std::optional<LevelPoint> match_near(const GreyImage& left, const GreyImage& right, const Eigen::Vector2i& pixel,
                                     const Prediction& plane, const GrowthOptions& options) {
  const ShapedMatcher matcher(left, pixel, options.half, right,
                              {.low_px = plane.disparity_px - kNear_px,
                               .high_px = plane.disparity_px + kNear_px,
                               .rows = options.rows(pixel),
                               .return_px = options.return_px});
  return measured_match(left, options.half, right, matcher.match(plane.gradient), options.min_ncc);
}

// The best of those that planes of neighbours lead to.
std::optional<LevelPoint> match_by_neighbours(const GreyImage& left, const GreyImage& right,
                                              const Eigen::Vector2i& pixel, std::span<const LevelPoint> points,
                                              std::span<const std::size_t> neighbours, const GrowthOptions& options) {
  const Eigen::Vector2d at = pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5);
  std::vector<Prediction> tried;
  std::optional<LevelPoint> best;
  for (const std::size_t i : neighbours) {
    const Eigen::Vector2d gradient = points[i].gradient.cwiseMax(-kSteepest).cwiseMin(kSteepest);
    const Prediction plane{points[i].disparity_px + gradient.dot(at - points[i].left_px), gradient};
    const auto is_same = [&](const Prediction& other) {
      return std::abs(other.disparity_px - plane.disparity_px) < kSame_px &&
             (other.gradient - plane.gradient).cwiseAbs().maxCoeff() < kSameGradient;
    };
    if (std::any_of(tried.begin(), tried.end(), is_same)) continue;
    tried.push_back(plane);
    const auto found = match_near(left, right, pixel, plane, options);
    if (found && (!best || found->ncc > best->ncc)) best = found;
  }
  return best;
}

}  // namespace

std::vector<LevelPoint> matched_near(const GreyImage& left, const GreyImage& right,
                                     std::span<const Eigen::Vector2i> pixels, std::span<const LevelPoint> model,
                                     const GrowthOptions& options, const Run& run) {
  if (model.empty()) return {};
  const PlaneSquares squares(left_positions(model));
  std::vector<std::optional<LevelPoint>> found(pixels.size());
  const std::size_t blocks = (pixels.size() + kBlock - 1) / kBlock;
  std::atomic<std::size_t> done{0};
  parallel_for(run, blocks, [&](std::size_t block) {
    for (std::size_t i = block * kBlock; i < std::min((block + 1) * kBlock, pixels.size()); ++i) {
      const Eigen::Vector2d at = pixels[i].cast<double>() + Eigen::Vector2d(0.5, 0.5);
      found[i] =
          match_by_neighbours(left, right, pixels[i], model, squares.nearest(at, kNearest, kFarthest_px), options);
    }
    run.report("levels", double(++done) / double(blocks));
  });
  std::vector<LevelPoint> points;
  for (const auto& each : found)
    if (each) points.push_back(*each);
  return points;
}

std::vector<LevelPoint> grown(const GreyImage& left, const GreyImage& right, std::span<const Eigen::Vector2i> pixels,
                              std::vector<LevelPoint> points, const GrowthOptions& options, const Run& run) {
  GrownGrid grid(left, pixels, points, options.step_px);
  std::size_t first = 0;  // of the points that the last pass found
  while (first < points.size() && !run.stopped()) {
    const std::size_t last = points.size();
    const std::vector<std::size_t> open = grid.unmatched_near(points, first);
    std::vector<std::optional<LevelPoint>> found(open.size());
    parallel_for(run, (open.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
      std::vector<std::size_t> neighbours;
      for (std::size_t i = block * kBlock; i < std::min((block + 1) * kBlock, open.size()); ++i) {
        grid.neighbours(pixels[open[i]], first, neighbours);
        found[i] = match_by_neighbours(left, right, pixels[open[i]], points, neighbours, options);
      }
    });
    for (std::size_t i = 0; i < open.size(); ++i)
      if (found[i]) {
        grid.set(pixels[open[i]], points.size());
        points.push_back(*found[i]);
      }
    first = last;
  }
  return points;
}

}  // namespace collinea
