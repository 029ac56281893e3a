// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/curve_matching.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/feature/edge_correlation.h"
#include "collinea/match/relaxation.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kRotationSigma_rad = 15 * kDegree;
constexpr double kLargestStep_px = 2;     // between neighbours of one arc
constexpr double kLeastRise_px = 1e-6;    // from row to row
constexpr double kSharedRows = 0.2;       // of the shorter one, with which two candidates contradict each other
constexpr std::size_t kSampledRows = 60;  // of a candidate

double alike(double difference, double sigma) { return std::exp(-0.5 * std::pow(difference / sigma, 2)); }

// Whether an arc goes on from one point of a chain to the next.
bool goes_on(const EdgePoint& a, const EdgePoint& b, double sense) {
  return (b.at - a.at).norm() <= kLargestStep_px && sense * (b.at.y() - a.at.y()) > kLeastRise_px &&
         a.normal.x() * b.normal.x() > 0;
}

std::optional<double> median_beside(const FloatImage& image, std::span<const EdgePoint> points, double side) {
  std::vector<float> values;
  for (const EdgePoint& p : points)
    for (const double off_px : {2.0, 3.0, 4.0}) {
      const Vector2d at = p.at + side * off_px * p.normal;
      const int x = int(std::floor(at.x())), y = int(std::floor(at.y()));
      if (x >= 0 && y >= 0 && x < image.width && y < image.height) values.push_back(image.at(x, y));
    }
  if (2 * values.size() < 3 * points.size()) return std::nullopt;
  return median(values);
}

// The arcs of one chain, whose points are taken from a break on where it is closed.
class ChainCutter {
 public:
  ChainCutter(const EdgeMap& map, const FloatImage& image, std::size_t least_points, std::vector<EdgeArc>& out)
      : map_(map), image_(image), least_points_(least_points), out_(out) {}

  void add(const EdgePoint& p, bool is_usable) {
    if (!is_usable) return finish();
    if (!run_.empty()) {
      const double rise = p.at.y() - run_.back().at.y();
      if (run_.size() == 1) sense_ = rise < 0 ? -1 : 1;
      if (!goes_on(run_.back(), p, sense_)) finish();
    }
    run_.push_back(p);
  }
  void finish() {
    std::vector<EdgePoint> points = std::move(run_);
    run_.clear();
    if (points.size() < std::max<std::size_t>(least_points_, 2)) return;
    if (sense_ < 0) std::reverse(points.begin(), points.end());
    const auto darker = median_beside(image_, points, -1), brighter = median_beside(image_, points, 1);
    if (darker && brighter) out_.push_back({std::move(points), {*darker, *brighter}, map_.along_px});
  }

 private:
  const EdgeMap& map_;
  const FloatImage& image_;
  std::size_t least_points_;
  std::vector<EdgeArc>& out_;
  std::vector<EdgePoint> run_;
  double sense_ = 1;
};

std::optional<ArcMatch> candidate_of(const EdgeArc& left, const EdgeArc& right, double low_px, double high_px,
                                     const LineMatchOptions& o) {
  if (!(left.points.front().normal.x() * right.points.front().normal.x() > 0)) return std::nullopt;
  ArcMatch m;
  m.first_row = std::max(left.first_row(), right.first_row());
  m.last_row = std::min(left.last_row(), right.last_row());
  const double shorter = std::min(left.last_row() - left.first_row(), right.last_row() - right.first_row());
  const double overlap = (m.last_row - m.first_row) / std::max(shorter, 1e-9);
  if (!(m.last_row > m.first_row) || !(overlap >= o.least_overlap)) return std::nullopt;
  const auto count = std::clamp<std::size_t>(std::size_t(m.last_row - m.first_row), 2, kSampledRows);
  std::vector<double> disparities, rotations;
  for (std::size_t i = 0; i < count; ++i) {
    const double row = m.first_row + (m.last_row - m.first_row) * double(i) / double(count - 1);
    const auto a = crossing(left, row), b = crossing(right, row);
    if (!a || !b) continue;
    const double disparity = a->column - b->column;
    if (!(disparity >= low_px && disparity <= high_px)) return std::nullopt;
    disparities.push_back(disparity);
    rotations.push_back(std::remainder(
        std::atan2(b->normal.y(), b->normal.x()) - std::atan2(a->normal.y(), a->normal.x()), 2 * std::numbers::pi));
  }
  if (disparities.size() < 2) return std::nullopt;
  m.lowest_px = *std::min_element(disparities.begin(), disparities.end());
  m.highest_px = *std::max_element(disparities.begin(), disparities.end());
  m.median_disparity_px = median(disparities);
  m.rotation_rad = median(rotations);
  if (!(std::abs(m.rotation_rad) <= o.largest_rotation_deg * kDegree)) return std::nullopt;
  m.similarity = std::min(overlap, 1.0) * alike(m.rotation_rad, kRotationSigma_rad) *
                 (alike(left.greys.darker - right.greys.darker, o.grey_sigma) +
                  alike(left.greys.brighter - right.greys.brighter, o.grey_sigma)) /
                 2;
  if (!(m.similarity >= o.least_similarity)) return std::nullopt;
  return m;
}

std::vector<ArcMatch> candidates_of(std::span<const EdgeArc> left, std::span<const EdgeArc> right, double low_px,
                                    double high_px, const LineMatchOptions& options) {
  std::vector<ArcMatch> out;
  for (std::size_t i = 0; i < left.size(); ++i)
    for (std::size_t j = 0; j < right.size(); ++j)
      if (auto m = candidate_of(left[i], right[j], low_px, high_px, options)) {
        m->left = i;
        m->right = j;
        out.push_back(*m);
      }
  return out;
}

bool contradict(const ArcMatch& a, const ArcMatch& b) {
  const double shared = std::min(a.last_row, b.last_row) - std::max(a.first_row, b.first_row);
  return shared > kSharedRows * std::min(a.last_row - a.first_row, b.last_row - b.first_row);
}

using Conflicts = std::vector<std::vector<std::size_t>>;

// Of each candidate those that contradict it and have its left (its right) arc.
Conflicts conflicts_of(const std::vector<ArcMatch>& all, std::size_t ArcMatch::*side) {
  std::vector<std::vector<std::size_t>> of_arc;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (of_arc.size() <= all[k].*side) of_arc.resize(all[k].*side + 1);
    of_arc[all[k].*side].push_back(k);
  }
  Conflicts out(all.size());
  for (const auto& arc : of_arc)
    for (const std::size_t a : arc)
      for (const std::size_t b : arc)
        if (a != b && contradict(all[a], all[b])) out[a].push_back(b);
  return out;
}

// Candidates that are decided, or still open, or excluded by what is decided.
enum class State : char { kOpen, kDecided, kExcluded };

class Decisions {
 public:
  Decisions(std::span<const EdgeArc> left, std::vector<ArcMatch>& all)
      : left_(left),
        all_(all),
        conflicts_{conflicts_of(all, &ArcMatch::left), conflicts_of(all, &ArcMatch::right)},
        state_(all.size(), State::kOpen) {}

  // Two that contradict each other and are as similar are both left open, as by_neighbours() does.
  void by_similarity(double ratio) {
    std::vector<std::size_t> decisive;
    for (std::size_t k = 0; k < all_.size(); ++k) {
      bool is_decisive = true;
      for (const Conflicts& side : conflicts_)
        for (const std::size_t other : side[k]) is_decisive &= all_[k].similarity >= ratio * all_[other].similarity;
      if (is_decisive) decisive.push_back(k);
    }
    for (const std::size_t k : decisive) {
      if (!is_alone(k, decisive)) continue;
      all_[k].outcome =
          conflicts_[0][k].empty() && conflicts_[1][k].empty() ? LineOutcome::kOne : LineOutcome::kDecisive;
      decide(k);
    }
  }

  // Those that are decided bear out what is open; two that contradict each other are both left open.
  void by_neighbours() {
    std::vector<std::size_t> anchors, chosen;
    for (std::size_t k = 0; k < all_.size(); ++k)
      if (state_[k] == State::kDecided) anchors.push_back(k);
    for (std::size_t k = 0; k < all_.size(); ++k)
      if (state_[k] == State::kOpen && is_borne_out(k, conflicts_[0][k], anchors) &&
          is_borne_out(k, conflicts_[1][k], anchors))
        chosen.push_back(k);
    for (const std::size_t k : chosen) {
      if (!is_alone(k, chosen)) continue;
      all_[k].outcome = LineOutcome::kByNeighbours;
      state_[k] = State::kDecided;
    }
    for (std::size_t k = 0; k < all_.size(); ++k)
      if (state_[k] == State::kDecided) decide(k);
  }

  [[nodiscard]] ArcMatches result() const {
    ArcMatches out{{}, all_.size(), 0};
    for (std::size_t k = 0; k < all_.size(); ++k) {
      if (state_[k] == State::kDecided) out.matches.push_back(all_[k]);
      out.undecided += state_[k] == State::kOpen;
    }
    std::stable_sort(out.matches.begin(), out.matches.end(), [](const ArcMatch& a, const ArcMatch& b) {
      return std::pair(a.left, a.first_row) < std::pair(b.left, b.first_row);
    });
    return out;
  }

 private:
  // Whether none of the others contradicts a candidate.
  [[nodiscard]] bool is_alone(std::size_t k, const std::vector<std::size_t>& others) const {
    return std::ranges::none_of(others, [&](std::size_t other) {
      return std::ranges::count(conflicts_[0][k], other) + std::ranges::count(conflicts_[1][k], other) > 0;
    });
  }
  void decide(std::size_t k) {
    state_[k] = State::kDecided;
    for (const Conflicts& side : conflicts_)
      for (const std::size_t other : side[k]) state_[other] = State::kExcluded;
  }
  [[nodiscard]] Vector2d middle_of(std::size_t k) const {
    const double row = (all_[k].first_row + all_[k].last_row) / 2;
    const auto at = crossing(left_[all_[k].left], row);
    return {at ? at->column : left_[all_[k].left].points.front().at.x(), row};
  }
  [[nodiscard]] PointCandidates as_point(const Vector2d& at, std::span<const std::size_t> which,
                                         bool is_decided) const {
    PointCandidates out{at, at, {}};
    for (const std::size_t k : which)
      out.candidates.push_back({at - Vector2d(all_[k].median_disparity_px, 0), is_decided ? 1 : all_[k].similarity});
    return out;
  }
  // Whether the nearest decided ones choose a candidate among those that contradict it on one side.
  [[nodiscard]] bool is_borne_out(std::size_t k, const std::vector<std::size_t>& against,
                                  std::vector<std::size_t>& anchors) const {
    const RelaxationOptions options;
    std::vector<std::size_t> asked{k};
    for (const std::size_t other : against)
      if (state_[other] == State::kOpen) asked.push_back(other);
    const Vector2d at = middle_of(k);
    const auto distance = [&](std::size_t a) { return (middle_of(a) - at).squaredNorm(); };
    const auto wanted = std::ptrdiff_t(std::min(std::size_t(options.neighbours), anchors.size()));
    std::partial_sort(anchors.begin(), anchors.begin() + wanted, anchors.end(), [&](std::size_t a, std::size_t b) {
      return std::pair(distance(a), a) < std::pair(distance(b), b);
    });
    std::vector<PointCandidates> points{as_point(at, asked, false)};
    for (const std::size_t a : std::span(anchors).first(std::size_t(wanted)))
      points.push_back(as_point(middle_of(a), std::span(&a, 1), true));
    return relax(points, options)[0].candidate == std::size_t{0};
  }

  std::span<const EdgeArc> left_;
  std::vector<ArcMatch>& all_;
  Conflicts conflicts_[2];
  std::vector<State> state_;
};

}  // namespace

std::vector<EdgeArc> edge_arcs(const EdgeMap& map, const FloatImage& image, double least_row_angle_deg,
                               int least_points, const std::function<bool(const Vector2d&)>& is_left_out) {
  const double least = std::sin(least_row_angle_deg * kDegree);
  std::vector<EdgeArc> out;
  for (const EdgeChain& chain : map.chains) {
    const auto points = map.points_of(chain);
    std::vector<char> is_usable;
    for (const EdgePoint& p : points)
      is_usable.push_back(std::abs(p.normal.x()) >= least && !(is_left_out && is_left_out(p.at)));
    // A closed chain has a point along the rows, where it may begin.
    const std::size_t begin =
        chain.is_closed ? std::size_t(std::find(is_usable.begin(), is_usable.end(), 0) - is_usable.begin()) : 0;
    ChainCutter cutter(map, image, std::size_t(least_points), out);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::size_t k = (begin + i) % points.size();
      cutter.add(points[k], is_usable[k] != 0);
    }
    cutter.finish();
  }
  return out;
}

std::optional<ArcCrossing> crossing(const EdgeArc& arc, double row) {
  const auto& points = arc.points;
  if (points.size() < 2 || !(row >= arc.first_row() && row <= arc.last_row())) return std::nullopt;
  auto next = std::upper_bound(points.begin() + 1, points.end() - 1, row,
                               [](double r, const EdgePoint& p) { return r < p.at.y(); });
  const EdgePoint &b = *next, &a = *(next - 1);
  const double share = (row - a.at.y()) / (b.at.y() - a.at.y());
  const double correlation = edge_correlation(a, b, arc.along_px);
  ArcCrossing out;
  out.column = (1 - share) * a.at.x() + share * b.at.x();
  out.normal = ((1 - share) * a.normal + share * b.normal).normalized();
  const double first = (1 - share) * a.sigma_px, second = share * b.sigma_px;
  out.sigma_px = std::sqrt(first * first + second * second + 2 * correlation * first * second) /
                 std::max(std::abs(out.normal.x()), 1e-6);
  return out;
}

ArcMatches match_arcs(std::span<const EdgeArc> left, std::span<const EdgeArc> right, double low_px, double high_px,
                      const LineMatchOptions& options) {
  std::vector<ArcMatch> all = candidates_of(left, right, low_px, high_px, options);
  Decisions decisions(left, all);
  decisions.by_similarity(options.decisive_ratio);
  decisions.by_neighbours();
  return decisions.result();
}

std::vector<EdgePointMatch> arc_point_matches(const ArcMatch& match, const EdgeArc& left, const EdgeArc& right) {
  std::vector<EdgePointMatch> out;
  for (const EdgePoint& p : left.points) {
    if (p.at.y() < match.first_row || p.at.y() > match.last_row) continue;
    if (const auto there = crossing(right, p.at.y()))
      out.push_back(
          {p.at, {there->column, p.at.y()}, std::hypot(p.sigma_px / std::abs(p.normal.x()), there->sigma_px)});
  }
  return out;
}

}  // namespace collinea
