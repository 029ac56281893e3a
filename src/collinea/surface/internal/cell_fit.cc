// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/cell_fit.h"

#include <algorithm>
#include <cmath>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kUse = 1.5;                // points up to here take part in the fit [cells]
constexpr double kSteepest = 1.5;           // rise per run that still is one surface
const double kAside = 1 / std::sqrt(12.0);  // standard deviation of a position that is known to a pixel [cells]

double distance2(const CellPoint& p) { return p.x * p.x + p.y * p.y; }

bool agrees(const CellPoint& p, double low_m, double high_m, double tolerance_m, double cell_m) {
  const double slack = tolerance_m + kSteepest * cell_m * std::sqrt(distance2(p));
  return p.height_m >= low_m - slack && p.height_m <= high_m + slack;
}

bool has_support(std::span<const CellPoint> near, double low_m, double high_m, double tolerance_m, double cell_m) {
  const std::size_t needed = near.size() <= 6 ? 2 : std::max<std::size_t>(3, near.size() / 10);
  std::size_t support = 0;
  for (const CellPoint& p : near) support += agrees(p, low_m, high_m, tolerance_m, cell_m);
  return support >= needed;
}

// A weight by distance that looks like a Gaussian and ends at the reach.
double nearness(double d2, double reach) {
  const double t = 1 - d2 / (1.2 * reach * reach);
  return t * t * t;
}

// A point stands for its surroundings only so well, however precise it is.
double variance_of(const CellPoint& p, double cell_m) { return double(p.sigma_m) * p.sigma_m + 0.01 * cell_m * cell_m; }

// The harmonic mean: a few points of large sigma do not matter.
double typical_sigma_m(std::span<const CellPoint> near) {
  double sum = 0;
  for (const CellPoint& p : near) sum += 1.0 / double(std::max(p.sigma_m, 1e-9f));
  return double(near.size()) / sum;
}

}  // namespace

double share_alike(double length_cells) {
  constexpr double kOwn = 0.07;          // of the variance, that even the nearest points do not share
  constexpr double kBetween = 4 * 0.27;  // of distances of two points in the weights of a fit, mean square [cells^2]
  const double length2 = length_cells * length_cells;
  return (1 - kOwn) * length2 / (length2 + kBetween / 2);
}

std::optional<CellEstimate> CellFit::estimate(std::span<const CellPoint> near, double cell_m) {
  if (near.empty()) return std::nullopt;
  const double sigma_m = typical_sigma_m(near);
  // Smaller would take the upper tail of the noise for a level of its own and lift flat ground.
  const double tolerance_m = std::max(4 * sigma_m, cell_m);
  const auto level_m = level(near, tolerance_m, cell_m);
  if (!level_m) return std::nullopt;
  const double floor_m = std::max(sigma_m, 0.02 * cell_m);
  select(near, *level_m, tolerance_m, cell_m, kUse);
  if (used_.empty()) return std::nullopt;
  Plane plane = fit_robustly(floor_m, 1.5);
  if (!plane.fixed) {
    select(near, *level_m, tolerance_m, cell_m, kCellReach);
    plane = fit_robustly(floor_m, 3);
    // At the rim of a hole an empty cell would only repeat its neighbour.
    const bool any_own = std::any_of(near.begin(), near.end(), [](const CellPoint& p) { return p.own; });
    if (!plane.fixed && !any_own) return std::nullopt;
  }
  const auto points = std::count_if(used_.begin(), used_.end(), [](const Weighted& w) { return w.weight > 0; });
  return CellEstimate{plane.at_centre, sigma_of(plane, cell_m), int(points)};
}

std::optional<double> CellFit::level(std::span<const CellPoint> near, double tolerance_m, double cell_m) {
  const bool any_own = std::any_of(near.begin(), near.end(), [](const CellPoint& p) { return p.own; });
  return any_own ? level_of_own(near, tolerance_m, cell_m) : level_of_nearest(near, tolerance_m, cell_m);
}

std::optional<double> CellFit::level_of_own(std::span<const CellPoint> near, double tolerance_m, double cell_m) {
  std::vector<double>& heights = numbers_;
  heights.clear();
  for (const CellPoint& p : near)
    if (p.own) heights.push_back(p.height_m);
  std::sort(heights.begin(), heights.end());
  for (std::size_t end = heights.size(); end > 0;) {
    std::size_t begin = end - 1;
    while (begin > 0 && heights[begin] - heights[begin - 1] <= tolerance_m) --begin;
    // Points on a wall join roof and ground into one long cluster: only its top is the surface seen from above.
    const double low_m = std::max(heights[begin], heights[end - 1] - 2 * tolerance_m);
    if (has_support(near, low_m, heights[end - 1], tolerance_m, cell_m)) {
      const auto first =
          std::lower_bound(heights.begin() + std::ptrdiff_t(begin), heights.begin() + std::ptrdiff_t(end), low_m);
      return *(first + (heights.begin() + std::ptrdiff_t(end) - first) / 2);
    }
    end = begin;
  }
  return std::nullopt;
}

std::optional<double> CellFit::level_of_nearest(std::span<const CellPoint> near, double tolerance_m, double cell_m) {
  const CellPoint* nearest = nullptr;
  for (const CellPoint& p : near) {
    if (distance2(p) > kUse * kUse || (nearest && distance2(p) >= distance2(*nearest))) continue;
    if (has_support(near, p.height_m, p.height_m, tolerance_m, cell_m)) nearest = &p;
  }
  if (!nearest) return std::nullopt;
  return nearest->height_m;
}

void CellFit::select(std::span<const CellPoint> near, double level_m, double tolerance_m, double cell_m, double reach) {
  used_.clear();
  for (const CellPoint& p : near) {
    const double d2 = distance2(p);
    if (d2 > reach * reach || !agrees(p, level_m, level_m, tolerance_m, cell_m)) continue;
    const double weight = nearness(d2, reach) / variance_of(p, cell_m);
    used_.push_back({&p, weight, weight, 0});
  }
}

CellFit::Plane CellFit::fit_plane(double most_leverage) const {
  double w = 0, x = 0, y = 0, z = 0;
  const double z0 = used_.front().point->height_m;  // small numbers keep their digits
  int points = 0;
  for (const Weighted& u : used_) {
    w += u.weight;
    x += u.weight * u.point->x;
    y += u.weight * u.point->y;
    z += u.weight * (u.point->height_m - z0);
    points += u.weight > 0;
  }
  x /= w, y /= w, z /= w;
  Plane plane{z0 + z, 0, 0, 0, false};
  if (points < 4) return plane;
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0;
  for (const Weighted& u : used_) {
    const double dx = u.point->x - x, dy = u.point->y - y, dz = u.point->height_m - z0 - z;
    xx += u.weight * dx * dx, xy += u.weight * dx * dy, yy += u.weight * dy * dy;
    xz += u.weight * dx * dz, yz += u.weight * dy * dz;
  }
  xx /= w, xy /= w, yy /= w, xz /= w, yz /= w;
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 0.03 * (xx + yy))) return plane;  // the points lie nearly on a line, or all together
  // Far outside its points the plane is an extrapolation of noise: there the mean is better.
  const double leverage = (yy * x * x - 2 * xy * x * y + xx * y * y) / determinant;
  if (leverage > most_leverage) return plane;
  plane.slope_x = (yy * xz - xy * yz) / determinant;
  plane.slope_y = (xx * yz - xy * xz) / determinant;
  plane.at_centre -= plane.slope_x * x + plane.slope_y * y;
  plane.leverage = leverage;
  plane.fixed = true;
  return plane;
}

CellFit::Plane CellFit::fit_robustly(double floor_m, double most_leverage) {
  constexpr int kRounds = 3;
  Plane plane;
  for (int round = 0;; ++round) {
    plane = fit_plane(most_leverage);
    double largest = 0;
    numbers_.clear();
    for (Weighted& u : used_) {
      u.residual = u.point->height_m - (plane.at_centre + plane.slope_x * u.point->x + plane.slope_y * u.point->y);
      largest = std::max(largest, std::abs(u.residual));
      numbers_.push_back(std::abs(u.residual));
    }
    if (round == kRounds || largest <= 3 * floor_m || used_.size() < 3) return plane;
    const double scale = std::max(1.4826 * median(numbers_), floor_m);
    if (largest <= 3 * scale) return plane;
    for (Weighted& u : used_) {
      const double r = u.residual / (5 * scale);
      u.weight = r * r < 1 ? u.fixed_weight * (1 - r * r) * (1 - r * r) : 0;
    }
  }
}

double CellFit::sigma_of(const Plane& plane, double cell_m) const {
  double w = 0, ws = 0, w2v = 0, misfit = 0, expected = 0;
  int points = 0;
  for (const Weighted& u : used_) {
    const double variance = variance_of(*u.point, cell_m);
    w += u.weight;
    ws += u.weight * double(u.point->sigma_m);
    w2v += u.weight * u.weight * variance;
    misfit += u.weight * u.residual * u.residual;
    expected += u.weight * variance;
    points += u.weight > 0;
  }
  // Points scatter by what they do not share; how much a few of them do is chance.
  double factor = 1 - alike_;
  if (points > 4) factor = std::max(factor, misfit / expected * points / (points - 3));
  // All points of a window are aside together.
  const double aside2 = kAside * kAside * (plane.slope_x * plane.slope_x + plane.slope_y * plane.slope_y);
  return std::sqrt(alike_ * ws * ws / (w * w) + w2v / (w * w) * (1 + plane.leverage) * factor + aside2);
}

}  // namespace collinea
