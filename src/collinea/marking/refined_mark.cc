// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/refined_mark.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "collinea/feature/edges.h"
#include "collinea/feature/tags.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kSearchRadii[] = {3, 4, 6, 9, 14};                      // where candidates are looked for
constexpr int kRadii[] = {3, 4, 5, 6, 7, 8, 10, 12, 14, 17, 20, 24};  // in which they are measured

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
  std::vector<double> residuals(std::size_t(side) * std::size_t(side));  // zero of pixels that do not count
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const Vector2d p(left + x + 0.5, top + y + 0.5);
      if (!counts_in_window(radius, p - target.at)) continue;
      fit.pixels += 1;
      const double grey = image.at(left + x, top + y);
      const Vector3d row(1, x - radius, y - radius);
      normal += row * row.transpose();
      right += grey * row;
      squares += grey * grey;
      const std::size_t at = std::size_t(y) * std::size_t(side) + std::size_t(x);
      residuals[at] = grey - target_grey(target.kind, target.unknowns, p);
      fit.of_target += residuals[at] * residuals[at];
      if (x > 0) neighbours += residuals[at] * residuals[at - 1] / 2;
      if (y > 0) neighbours += residuals[at] * residuals[at - std::size_t(side)] / 2;
    }
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
  Measured out{{marked_kind(target.kind), target.at, target.covariance, radius, 1 - fit.of_target / fit.of_plane},
               evidence(fit, target.unknowns.size())};
  const bool holds = out.mark.explained >= kLeastExplained && out.mark.sigma_px() <= kLargestSigma_px && out.odds > 0;
  return holds ? std::optional(out) : std::nullopt;
}

// Positions where a target of a kind may lie, those that the search measured; and the click itself.
std::vector<Vector2d> candidates(const FloatImage& image, const EdgeMap& edges, TargetKind kind,
                                 const Vector2d& click) {
  std::vector<Vector2d> all{click};
  for (const int radius : kSearchRadii) {
    for (const Target& target : find_targets(
             image, edges, kind, {.radius_px = radius, .least_contrast = 8, .largest_residual = 0.25, .most = 50}))
      if ((target.at - click).norm() <= kLargestMiss_px) all.push_back(target.at);
    if (kind == TargetKind::kCircle) break;  // they have no window
  }
  std::vector<Vector2d> apart;
  for (const Vector2d& one : all)
    if (std::none_of(apart.begin(), apart.end(), [&](const Vector2d& other) { return (one - other).norm() < 1; }))
      apart.push_back(one);
  return apart;
}

std::optional<Measured> best_of(const FloatImage& image, const EdgeMap& edges, TargetKind kind, const Vector2d& click) {
  constexpr double kSame_px = 0.1;
  std::optional<Measured> best;
  std::map<int, std::vector<Vector2d>> centres;  // that windows of a radius led to
  for (const Vector2d& start : candidates(image, edges, kind, click)) {
    int misses = 0;
    for (const int radius : kRadii) {
      const auto target = measure_target(image, kind, start, radius);
      if (target) {
        auto& known = centres[radius];
        const auto is_same = [&](const Vector2d& other) { return (target->at - other).norm() < kSame_px; };
        if (std::ranges::any_of(known, is_same)) break;  // another start has led here, and on
        known.push_back(target->at);
      }
      const auto one = target ? measured(image, *target, radius, click) : std::nullopt;
      if (one && (!best || one->odds > best->odds)) best = one;
      misses = one ? 0 : misses + 1;
      if (best && misses == 2) break;  // the window has outgrown the target
    }
  }
  return best;
}

}  // namespace

MarkedKind marked_kind(TargetKind kind) {
  return kind == TargetKind::kCircle  ? MarkedKind::kCircle
         : kind == TargetKind::kCross ? MarkedKind::kCross
                                      : MarkedKind::kChequerboard;
}

std::optional<TargetKind> target_kind(MarkedKind kind) {
  for (const Word<TargetKind>& word : kTargetKindWords)
    if (marked_kind(word.value) == kind) return word.value;
  return std::nullopt;
}

double RefinedMark::sigma_px() const {
  return std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues()[1]);
}

std::optional<RefinedMark> refined_mark(const FloatImage& image, const Vector2d& click,
                                        std::optional<TargetKind> kind) {
  if (!(click.x() >= 0 && click.y() >= 0 && click.x() <= image.width && click.y() <= image.height)) return std::nullopt;
  const EdgeMap edges = detect_edges(image, {});
  std::optional<Measured> best;
  for (const Word<TargetKind>& word : kTargetKindWords) {
    if (kind && *kind != word.value) continue;
    const auto one = best_of(image, edges, word.value, click);
    if (one && (!best || one->odds > best->odds)) best = one;
  }
  return best ? std::optional(best->mark) : std::nullopt;
}

std::optional<RefinedMark> tag_near(const FloatImage& image, const Vector2d& click) {
  std::optional<RefinedMark> best;
  if (!click.allFinite()) return best;
  for (const Tag& tag : find_tags(image, {})) {
    const double away = (tag.at - click).norm();
    if (away > std::max(kLargestMiss_px, 0.25 * tag.least_side_px())) continue;
    if (tag.sigma_px() > kLargestSigma_px || (best && away >= (best->pixel - click).norm())) continue;
    const double diagonal =
        std::max((tag.corners[2] - tag.corners[0]).norm(), (tag.corners[3] - tag.corners[1]).norm());
    best = RefinedMark{MarkedKind::kTag, tag.at, tag.covariance, int(std::ceil(diagonal / 2)), 0};
  }
  return best;
}

}  // namespace collinea
