// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/hough.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kAngles = 720;            // cells of a turn
constexpr int kAngleWindow = 10;        // cells on either side of a point's gradient that it votes for
constexpr double kNormalCosine = 0.95;  // between gradient and normal of the curve

// --- lines
// ------------------------------------------------------------------------------------------------------------

class LineVotes {
 public:
  explicit LineVotes(const EdgePoints& edges)
      : edges_(edges), reach_(int(std::ceil(std::hypot(edges.width, edges.height))) + 2), votes_(2 * reach_, kAngles) {
    for (std::size_t i = 0; i < edges.points.size(); ++i) vote(i, 1);
  }

  void vote(std::size_t i, int by) {
    const EdgePoint& p = edges_.points[i];
    const int middle = int(std::lround(std::atan2(p.normal.y(), p.normal.x()) / kTurn * kAngles));
    for (int k = middle - kAngleWindow; k <= middle + kAngleWindow; ++k) {
      const double theta = k * kTurn / kAngles;
      const double r = p.at.x() * std::cos(theta) + p.at.y() * std::sin(theta);
      votes_.at(int(std::floor(r)) + reach_, (k + 2 * kAngles) % kAngles) += by;
    }
  }
  // Two neighbouring cells of distance together: a line may run along their border.
  struct Peak {
    int votes = 0;
    double theta_rad = 0, r_px = 0;
    int cell = 0, angle = 0;
  };
  [[nodiscard]] Peak highest() const {
    Peak best;
    for (int k = 0; k < kAngles; ++k)
      for (int c = 0; c + 1 < votes_.width; ++c)
        if (const int sum = votes_.at(c, k) + votes_.at(c + 1, k); sum > best.votes)
          best = {sum, k * kTurn / kAngles, double(c + 1 - reach_), c, k};
    return best;
  }
  void discard(const Peak& peak) {
    votes_.at(peak.cell, peak.angle) = votes_.at(peak.cell + 1, peak.angle) = -1'000'000;
  }

 private:
  const EdgePoints& edges_;
  int reach_;
  Raster<std::int32_t> votes_;
};

std::vector<std::size_t> near_line(const EdgePoints& edges, const std::vector<char>& is_used, const Vector2d& normal,
                                   double r_px, double tolerance_px) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < edges.points.size(); ++i)
    if (!is_used[i] && std::abs(normal.dot(edges.points[i].at) - r_px) <= tolerance_px &&
        edges.points[i].normal.dot(normal) > kNormalCosine)
      out.push_back(i);
  return out;
}

std::vector<EdgePoint> chosen(const EdgePoints& edges, const std::vector<std::size_t>& which) {
  std::vector<EdgePoint> out;
  for (const std::size_t i : which) out.push_back(edges.points[i]);
  return out;
}

std::optional<FoundLine> adjusted_line(const EdgePoints& edges, const std::vector<char>& is_used, double theta_rad,
                                       double r_px, const HoughOptions& options) {
  Vector2d normal(std::cos(theta_rad), std::sin(theta_rad));
  std::optional<FoundLine> found;
  for (int pass = 0; pass < 3; ++pass) {
    const double tolerance = pass == 0 ? options.tolerance_px + 1 : options.tolerance_px;
    auto near = near_line(edges, is_used, normal, r_px, tolerance);
    if (near.size() < std::size_t(options.least_points)) return std::nullopt;
    const auto line = fit_line(chosen(edges, near), edges.along_px);
    if (!line) return std::nullopt;
    normal = line->normal();
    r_px = line->r_px;
    found = FoundLine{*line, std::move(near)};
  }
  return found;
}

// --- circles
// ----------------------------------------------------------------------------------------------------------

class CentreVotes {
 public:
  CentreVotes(const EdgePoints& edges, const HoughOptions& options)
      : edges_(edges), options_(options), votes_(edges.width, edges.height) {
    for (std::size_t i = 0; i < edges.points.size(); ++i) vote(i, 1);
  }

  void vote(std::size_t i, int by) {
    const EdgePoint& p = edges_.points[i];
    for (const double side : {-1.0, 1.0})
      for (double r = options_.smallest_radius_px; r <= options_.largest_radius_px; r += 1) {
        const Vector2d c = p.at + side * r * p.normal;
        if (c.x() < 0 || c.y() < 0 || c.x() >= votes_.width || c.y() >= votes_.height) break;
        votes_.at(int(c.x()), int(c.y())) += by;
      }
  }
  struct Peak {
    int votes = 0;
    Vector2d at = Vector2d::Zero();
    int x = 0, y = 0;
  };
  [[nodiscard]] Peak highest() const {
    Peak best;
    for (int y = 1; y + 1 < votes_.height; ++y)
      for (int x = 1; x + 1 < votes_.width; ++x) {
        int sum = 0;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) sum += votes_.at(x + dx, y + dy);
        if (sum > best.votes) best = {sum, Vector2d(x + 0.5, y + 0.5), x, y};
      }
    return best;
  }
  void discard(const Peak& peak) {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) votes_.at(peak.x + dx, peak.y + dy) = -1'000'000;
  }

 private:
  const EdgePoints& edges_;
  const HoughOptions& options_;
  Raster<std::int32_t> votes_;
};

bool looks_at(const EdgePoint& p, const Vector2d& centre) {
  const Vector2d d = p.at - centre;
  return std::abs(p.normal.dot(d)) > kNormalCosine * d.norm();
}

// The radius with the densest points: most for the length of the circle.
std::optional<double> radius_about(const EdgePoints& edges, const std::vector<char>& is_used, const Vector2d& centre,
                                   const HoughOptions& options) {
  std::vector<double> count(std::size_t(options.largest_radius_px) + 4);
  for (std::size_t i = 0; i < edges.points.size(); ++i) {
    const double r = (edges.points[i].at - centre).norm();
    if (!is_used[i] && r + 2 < double(count.size()) && looks_at(edges.points[i], centre)) count[std::size_t(r)] += 1;
  }
  std::optional<double> best;
  double density = 0;
  for (std::size_t k = 1; k + 1 < count.size(); ++k) {
    const double here = (count[k - 1] + count[k] + count[k + 1]) / (double(k) + 0.5);
    if (double(k) + 1 < options.smallest_radius_px || here <= density) continue;
    density = here;
    best = double(k) + 0.5;
  }
  return density > 0.5 * kTurn * options.least_arc ? best : std::nullopt;
}

std::optional<FoundCircle> adjusted_circle(const EdgePoints& edges, const std::vector<char>& is_used, Vector2d centre,
                                           const HoughOptions& options) {
  const auto start = radius_about(edges, is_used, centre, options);
  if (!start) return std::nullopt;
  double radius = *start;
  std::optional<FoundCircle> found;
  for (int pass = 0; pass < 4; ++pass) {
    const double tolerance = options.tolerance_px + (pass == 0 ? 1.5 : pass == 1 ? 0.5 : 0);
    FoundCircle next;
    for (std::size_t i = 0; i < edges.points.size(); ++i)
      if (!is_used[i] && std::abs((edges.points[i].at - centre).norm() - radius) <= tolerance &&
          looks_at(edges.points[i], centre))
        next.points.push_back(i);
    if (next.points.size() < std::size_t(options.least_points)) return std::nullopt;
    const auto circle = fit_circle(chosen(edges, next.points), edges.along_px);
    if (!circle || circle->radius_px > options.largest_radius_px + 1) return std::nullopt;
    centre = circle->centre;
    radius = circle->radius_px;
    next.circle = *circle;
    found = std::move(next);
  }
  if (found->circle.arc_rad < options.least_arc * kTurn || radius < options.smallest_radius_px) return std::nullopt;
  return found;
}

// Peaks one after another, until they are too low: `adjust` makes of one what it stands for, or nothing.
template <class Found, class Votes, class Adjust>
std::vector<Found> peaks(const EdgePoints& edges, Votes& votes, const HoughOptions& options, const Adjust& adjust) {
  std::vector<Found> out;
  std::vector<char> is_used(edges.points.size(), 0);
  for (int failures = 0; out.size() < std::size_t(options.most) && failures < 50;) {
    const auto peak = votes.highest();
    if (peak.votes < options.least_points / 2) break;
    auto found = adjust(is_used, peak);
    if (!found) {
      votes.discard(peak);
      ++failures;
      continue;
    }
    for (const std::size_t i : found->points) {
      votes.vote(i, -1);
      is_used[i] = 1;
    }
    out.push_back(std::move(*found));
  }
  return out;
}

}  // namespace

std::vector<FoundLine> hough_lines(const EdgePoints& edges, const HoughOptions& options) {
  LineVotes votes(edges);
  auto out = peaks<FoundLine>(edges, votes, options, [&](const std::vector<char>& is_used, const LineVotes::Peak& p) {
    return adjusted_line(edges, is_used, p.theta_rad, p.r_px, options);
  });
  std::stable_sort(out.begin(), out.end(),
                   [](const FoundLine& a, const FoundLine& b) { return a.points.size() > b.points.size(); });
  return out;
}

std::vector<FoundCircle> hough_circles(const EdgePoints& edges, const HoughOptions& options) {
  CentreVotes votes(edges, options);
  return peaks<FoundCircle>(edges, votes, options, [&](const std::vector<char>& is_used, const CentreVotes::Peak& p) {
    return adjusted_circle(edges, is_used, p.at, options);
  });
}

}  // namespace collinea
