// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/refined_mark.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/feature/edges.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kSearchRadii[] = {4, 6, 9, 14};                      // where candidates are looked for
constexpr int kRadii[] = {4, 5, 6, 7, 8, 10, 12, 14, 17, 20, 24};  // in which they are measured

/// Squares of the grey values of a window about a plane, and what a target leaves of them.
struct Fit {
  double pixels = 0;
  double of_plane = 0, of_target = 0;
  double alike = 1;  // independent residuals that a residual stands for
};

// About the centre, as measure_target() takes its window.
Fit fit_of(const FloatImage& image, const Target& target, int radius) {
  const int left = int(std::floor(target.at.x())) - radius, top = int(std::floor(target.at.y())) - radius;
  const int side = 2 * radius + 1;
  Fit fit;
  if (left < 0 || top < 0 || left + side > image.width || top + side > image.height) return fit;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  double squares = 0, neighbours = 0;
  std::vector<double> residuals(std::size_t(side) * std::size_t(side));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double grey = image.at(left + x, top + y);
      const Vector3d row(1, x - radius, y - radius);
      normal += row * row.transpose();
      right += grey * row;
      squares += grey * grey;
      const std::size_t at = std::size_t(y) * std::size_t(side) + std::size_t(x);
      residuals[at] = grey - target_grey(target.kind, target.unknowns, {left + x + 0.5, top + y + 0.5});
      fit.of_target += residuals[at] * residuals[at];
      if (x > 0) neighbours += residuals[at] * residuals[at - 1] / 2;
      if (y > 0) neighbours += residuals[at] * residuals[at - std::size_t(side)] / 2;
    }
  fit.pixels = double(residuals.size());
  fit.of_plane = squares - right.dot(normal.ldlt().solve(right));
  // Residuals with the correlation c of neighbours tell as much as (1 - c) / (1 + c) of them, along each axis.
  const double c = fit.of_target > 0 ? std::clamp(neighbours / fit.of_target, 0.0, 0.9) : 0;
  fit.alike = std::pow((1 + c) / (1 - c), 2);
  return fit;
}

double evidence(const Fit& fit, Eigen::Index unknowns) {
  const double n = std::max(fit.pixels / fit.alike, 1.0);
  return n * std::log(fit.of_plane / std::max(fit.of_target, 1e-12 * fit.of_plane)) -
         double(unknowns - 3) * std::log(n);
}

/// A measured target, and twice the logarithm of its odds.
struct Measured {
  RefinedMark mark;
  double odds = 0;
};

std::optional<Measured> measured(const FloatImage& image, const Target& target, int radius, const Vector2d& click) {
  const Fit fit = fit_of(image, target, radius);
  if (!(fit.of_plane > 0) || !((target.at - click).norm() <= kLargestMiss_px)) return std::nullopt;
  Measured out{{target.kind, target.at, target.covariance, radius, 1 - fit.of_target / fit.of_plane},
               evidence(fit, target.unknowns.size())};
  const bool holds = out.mark.explained >= kLeastExplained && out.mark.sigma_px() <= kLargestSigma_px && out.odds > 0;
  return holds ? std::optional(out) : std::nullopt;
}

/// Where a target may lie, and the radius of the window that showed it.
struct Start {
  Vector2d at;
  int radius;
};

// The part of an image about a position, and its corner.
std::pair<FloatImage, Vector2d> part_about(const FloatImage& image, const Vector2d& at, int reach) {
  const int left = std::clamp(int(at.x()) - reach, 0, image.width - 1);
  const int top = std::clamp(int(at.y()) - reach, 0, image.height - 1);
  const int right = std::min(int(at.x()) + reach + 1, image.width),
            bottom = std::min(int(at.y()) + reach + 1, image.height);
  FloatImage part(right - left, bottom - top);
  for (int y = 0; y < part.height; ++y) std::copy_n(image.row(top + y) + left, part.width, part.row(y));
  return {std::move(part), {left, top}};
}

// The best few that a search finds within reach of the click, in windows of several sizes; and the click itself.
std::vector<Start> starts_of(const FloatImage& image, TargetKind kind, const Vector2d& click) {
  constexpr std::size_t kMost = 3;  // in windows of one size
  std::vector<Start> starts;
  for (const int radius : kSearchRadii) {
    starts.push_back({click, radius});
    const bool is_circle = kind == TargetKind::kCircle;  // their edges have a size of their own
    if (is_circle && radius != kSearchRadii[0]) continue;
    const int reach = is_circle ? kRefineReach_px : int(kLargestMiss_px) + radius + 4;
    const auto [part, corner] = part_about(image, click, reach);
    const EdgeMap edges = is_circle ? detect_edges(part, {}) : EdgeMap();
    const TargetSearch search{.radius_px = radius, .least_contrast = 8, .largest_residual = 0.25, .most = kMost};
    for (const Target& target : find_targets(part, edges, kind, search)) {
      const int fitting = is_circle ? int(std::ceil(std::max(target.unknowns[7], target.unknowns[8]))) + 3 : radius;
      starts.push_back({target.at + corner, fitting});
    }
  }
  return starts;
}

// In windows that grow as long as they tell more.
std::optional<Measured> best_of(const FloatImage& image, TargetKind kind, const Vector2d& click) {
  std::optional<Measured> best;
  for (const Start& start : starts_of(image, kind, click)) {
    if ((start.at - click).norm() > kLargestMiss_px) continue;
    std::optional<Measured> before;
    for (const int radius : kRadii) {
      if (radius < start.radius) continue;
      const auto target = measure_target(image, kind, before ? before->mark.pixel : start.at, radius);
      const auto one = target ? measured(image, *target, radius, click) : std::nullopt;
      if (!one || (before && one->odds < before->odds)) break;
      before = one;
    }
    if (before && (!best || before->odds > best->odds)) best = before;
  }
  return best;
}

}  // namespace

double RefinedMark::sigma_px() const {
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues()[1]);
}

std::optional<RefinedMark> refined_mark(const FloatImage& image, const Vector2d& click,
                                        std::optional<TargetKind> kind) {
  if (!(click.x() >= 0 && click.y() >= 0 && click.x() <= image.width && click.y() <= image.height)) return std::nullopt;
  std::optional<Measured> best;
  for (const Word<TargetKind>& word : kTargetKindWords) {
    if (kind && *kind != word.value) continue;
    const auto one = best_of(image, word.value, click);
    if (one && (!best || one->odds > best->odds)) best = one;
  }
  return best ? std::optional(best->mark) : std::nullopt;
}

}  // namespace collinea
