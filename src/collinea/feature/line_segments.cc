// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/line_segments.h"

#include <algorithm>
#include <cmath>

#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kNearest_px = 2, kFarthest_px = 4;  // of grey values beside a line

Vector2d along(const EdgeLine& line) { return {-std::sin(line.theta_rad), std::cos(line.theta_rad)}; }

std::optional<FoundLine> piece_of(const EdgePoints& edges, std::span<const std::size_t> which) {
  std::vector<EdgePoint> points;
  for (const std::size_t i : which) points.push_back(edges.points[i]);
  const auto line = fit_line(points, edges.along_px);
  if (!line) return std::nullopt;
  return FoundLine{*line, {which.begin(), which.end()}};
}

std::optional<double> median_beside(const FloatImage& image, const EdgeLine& line, double side) {
  std::vector<double> greys;
  const int steps = std::max(1, int(line.length_px()));
  int outside = 0;
  for (int k = 0; k <= steps; ++k)
    for (double off = kNearest_px; off <= kFarthest_px; off += 1) {
      const Vector2d at = line.from + (line.to - line.from) * k / steps + side * off * line.normal();
      const int x = int(std::floor(at.x())), y = int(std::floor(at.y()));
      if (x < 0 || y < 0 || x >= image.width || y >= image.height)
        ++outside;
      else
        greys.push_back(image.at(x, y));
    }
  if (greys.size() <= std::size_t(outside)) return std::nullopt;
  return median(greys);
}

}  // namespace

std::vector<FoundLine> line_segments(const EdgePoints& edges, std::span<const FoundLine> lines, double gap_px,
                                     int least_points) {
  std::vector<FoundLine> out;
  for (const FoundLine& found : lines) {
    std::vector<std::size_t> order = found.points;
    const Vector2d direction = along(found.line);
    const auto position = [&](std::size_t i) { return direction.dot(edges.points[i].at); };
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return std::pair(position(a), a) < std::pair(position(b), b); });
    for (std::size_t first = 0, i = 0; i < order.size(); ++i) {
      if (i + 1 < order.size() && position(order[i + 1]) - position(order[i]) <= gap_px) continue;
      const std::span piece(order.data() + first, i + 1 - first);
      first = i + 1;
      if (piece.size() < std::size_t(std::max(least_points, 3))) continue;
      if (auto segment = piece_of(edges, piece)) out.push_back(std::move(*segment));
    }
  }
  return out;
}

std::optional<SideGreys> side_greys(const FloatImage& image, const EdgeLine& line) {
  const auto darker = median_beside(image, line, -1), brighter = median_beside(image, line, 1);
  if (!darker || !brighter) return std::nullopt;
  return SideGreys{*darker, *brighter};
}

double sigma_across(const EdgeLine& line, const Vector2d& at) {
  const Vector2d by(along(line).dot(at), -1);  // of n' x - r by theta and r
  return std::sqrt(std::max(by.dot(line.covariance * by), 0.0));
}

}  // namespace collinea
