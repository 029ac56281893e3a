// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/line_matching.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/match/relaxation.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kRotationSigma_rad = 15 * kDegree;
constexpr double kLeastSine = 1e-6;

struct Rows {
  double first, last;
  [[nodiscard]] double length() const { return last - first; }
};

Rows rows_of(const EdgeLine& line) {
  return {std::min(line.from.y(), line.to.y()), std::max(line.from.y(), line.to.y())};
}

// The sine of the angle between a line and the rows.
double row_sine(const EdgeLine& line) { return std::abs(std::cos(line.theta_rad)); }

double alike(double difference, double sigma) { return std::exp(-0.5 * std::pow(difference / sigma, 2)); }

std::optional<LineCandidate> candidate_of(const MatchableLine& left, const MatchableLine& right, double low_px,
                                          double high_px, const LineMatchOptions& o) {
  if (!(left.line.normal().x() * right.line.normal().x() > 0)) return std::nullopt;  // the brighter side
  LineCandidate c;
  c.rotation_rad = std::remainder(right.line.theta_rad - left.line.theta_rad, 2 * std::numbers::pi);
  if (!(std::abs(c.rotation_rad) <= o.largest_rotation_deg * kDegree)) return std::nullopt;
  const Rows a = rows_of(left.line), b = rows_of(right.line);
  c.first_row = std::max(a.first, b.first);
  c.last_row = std::min(a.last, b.last);
  c.overlap = (c.last_row - c.first_row) / std::max(std::min(a.length(), b.length()), 1e-9);
  if (!(c.last_row > c.first_row) || !(c.overlap >= o.least_overlap)) return std::nullopt;
  const auto disparity = [&](double row) {
    return crossing(left.line, row)->column - crossing(right.line, row)->column;
  };
  c.first_disparity = disparity(c.first_row);
  c.last_disparity = disparity(c.last_row);
  if (!(std::min(c.first_disparity, c.last_disparity) >= low_px) ||
      !(std::max(c.first_disparity, c.last_disparity) <= high_px))
    return std::nullopt;
  c.similarity = std::min(c.overlap, 1.0) * alike(c.rotation_rad, kRotationSigma_rad) *
                 (alike(left.greys.darker - right.greys.darker, o.grey_sigma) +
                  alike(left.greys.brighter - right.greys.brighter, o.grey_sigma)) /
                 2;
  if (!(c.similarity >= o.least_similarity)) return std::nullopt;
  return c;
}

// The candidates of each line of one side, most similar first.
using ByLine = std::vector<std::vector<std::size_t>>;

ByLine by_line(const std::vector<LineCandidate>& candidates, std::size_t lines, std::size_t LineCandidate::*side) {
  ByLine out(lines);
  for (std::size_t k = 0; k < candidates.size(); ++k) out[candidates[k].*side].push_back(k);
  for (auto& of_line : out)
    std::stable_sort(of_line.begin(), of_line.end(),
                     [&](std::size_t a, std::size_t b) { return candidates[a].similarity > candidates[b].similarity; });
  return out;
}

bool is_decisive(const std::vector<LineCandidate>& candidates, const std::vector<std::size_t>& of_line, double ratio) {
  return of_line.size() < 2 || candidates[of_line[0]].similarity >= ratio * candidates[of_line[1]].similarity;
}

// What of one side is decided, and what is not, for relaxation.
struct Side {
  std::span<const MatchableLine> lines;
  const ByLine& of_lines;                                // without what decided pairs exclude
  std::vector<std::optional<std::size_t>> decided = {};  // candidates, by line
};

Vector2d middle_of(const EdgeLine& line) { return (line.from + line.to) / 2; }

// A line with some candidates. The parallax of a candidate is its disparity, less a constant that does not matter.
PointCandidates as_point(const EdgeLine& line, const std::vector<LineCandidate>& candidates,
                         std::span<const std::size_t> which, bool is_decided) {
  PointCandidates out{middle_of(line), middle_of(line), {}};
  for (const std::size_t k : which)
    out.candidates.push_back(
        {out.point_px - Vector2d(candidates[k].middle_disparity(), 0), is_decided ? 1 : candidates[k].similarity});
  return out;
}

// For each line that is not decided the candidate that the decided ones nearest to it bear out. Those that are not
// decided have no say: a fence matches itself as well a picket farther.
std::vector<std::optional<std::size_t>> by_neighbours(const Side& side, const std::vector<LineCandidate>& candidates) {
  const RelaxationOptions options;
  std::vector<std::size_t> anchors;
  for (std::size_t k = 0; k < side.lines.size(); ++k)
    if (side.decided[k]) anchors.push_back(k);
  std::vector<std::optional<std::size_t>> out(side.lines.size());
  for (std::size_t i = 0; i < side.lines.size(); ++i) {
    if (side.decided[i] || side.of_lines[i].empty()) continue;
    const Vector2d middle = middle_of(side.lines[i].line);
    const auto distance = [&](std::size_t k) { return (middle_of(side.lines[k].line) - middle).squaredNorm(); };
    const auto wanted = std::ptrdiff_t(std::min(std::size_t(options.neighbours), anchors.size()));
    std::partial_sort(anchors.begin(), anchors.begin() + wanted, anchors.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(distance(a), a) < std::pair(distance(b), b);
    });
    std::vector<PointCandidates> points{as_point(side.lines[i].line, candidates, side.of_lines[i], false)};
    for (const std::size_t k : std::span(anchors).first(std::size_t(wanted)))
      points.push_back(as_point(side.lines[k].line, candidates, std::span(&*side.decided[k], 1), true));
    if (const auto best = relax(points, options)[0].candidate) out[i] = side.of_lines[i][*best];
  }
  return out;
}

// Drops from the lines of one side what decided pairs exclude.
void drop_excluded(const std::vector<LineCandidate>& candidates, const Side& left, const Side& right,
                   ByLine& of_lines) {
  for (auto& of_line : of_lines)
    std::erase_if(of_line, [&](std::size_t k) {
      const auto &there = left.decided[candidates[k].left], &back = right.decided[candidates[k].right];
      return (there || back) && there != k;
    });
}

}  // namespace

std::optional<RowCrossing> crossing(const EdgeLine& line, double row) {
  const double across = std::cos(line.theta_rad), along = std::sin(line.theta_rad);
  if (!(std::abs(across) > kLeastSine)) return std::nullopt;
  const Vector2d at((line.r_px - row * along) / across, row);
  return RowCrossing{at.x(), sigma_across(line, at) / std::abs(across)};
}

std::vector<LineCandidate> line_candidates(std::span<const MatchableLine> left, std::span<const MatchableLine> right,
                                           double low_px, double high_px, const LineMatchOptions& options) {
  const double least = std::sin(options.least_row_angle_deg * kDegree);
  std::vector<LineCandidate> out;
  for (std::size_t i = 0; i < left.size(); ++i) {
    if (row_sine(left[i].line) < least) continue;
    for (std::size_t j = 0; j < right.size(); ++j) {
      if (row_sine(right[j].line) < least) continue;
      auto candidate = candidate_of(left[i], right[j], low_px, high_px, options);
      if (!candidate) continue;
      candidate->left = i;
      candidate->right = j;
      out.push_back(*candidate);
    }
  }
  return out;
}

std::vector<LineDecision> match_lines(std::span<const MatchableLine> left, std::span<const MatchableLine> right,
                                      double low_px, double high_px, const LineMatchOptions& options) {
  const auto candidates = line_candidates(left, right, low_px, high_px, options);
  ByLine of_left = by_line(candidates, left.size(), &LineCandidate::left),
         of_right = by_line(candidates, right.size(), &LineCandidate::right);
  std::vector<LineDecision> out(left.size());
  const double least = std::sin(options.least_row_angle_deg * kDegree);
  for (std::size_t i = 0; i < left.size(); ++i) {
    out[i].candidates = of_left[i].size();
    if (row_sine(left[i].line) < least) out[i].outcome = LineOutcome::kAlongRows;
    if (of_left[i].empty()) continue;
    out[i].outcome = LineOutcome::kUndecided;
    const std::size_t best = of_left[i][0];
    const auto& back = of_right[candidates[best].right];
    if (back[0] != best || !is_decisive(candidates, of_left[i], options.decisive_ratio) ||
        !is_decisive(candidates, back, options.decisive_ratio))
      continue;
    out[i].outcome = of_left[i].size() == 1 && back.size() == 1 ? LineOutcome::kOne : LineOutcome::kDecisive;
    out[i].match = candidates[best];
  }
  Side one{left, of_left}, two{right, of_right};
  one.decided.resize(left.size());
  two.decided.resize(right.size());
  for (std::size_t i = 0; i < left.size(); ++i)
    if (out[i].match) one.decided[i] = two.decided[out[i].match->right] = of_left[i][0];
  drop_excluded(candidates, one, two, of_left);
  drop_excluded(candidates, one, two, of_right);
  const auto there = by_neighbours(one, candidates), back = by_neighbours(two, candidates);
  for (std::size_t i = 0; i < left.size(); ++i)
    if (there[i] && back[candidates[*there[i]].right] == there[i]) {
      out[i].outcome = LineOutcome::kByNeighbours;
      out[i].match = candidates[*there[i]];
    }
  return out;
}

std::vector<EdgePointMatch> edge_point_matches(const LineCandidate& match, std::span<const EdgePoint> left_points,
                                               const EdgeLine& right) {
  std::vector<EdgePointMatch> out;
  for (const EdgePoint& p : left_points) {
    if (p.at.y() < match.first_row || p.at.y() > match.last_row || !(std::abs(p.normal.x()) > kLeastSine)) continue;
    const auto there = crossing(right, p.at.y());
    if (!there) continue;
    out.push_back({p.at, {there->column, p.at.y()}, std::hypot(p.sigma_px / std::abs(p.normal.x()), there->sigma_px)});
  }
  return out;
}

}  // namespace collinea
