// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/relaxation.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr double kKept = 0.3, kSupported = 3;  // Barnard and Thompson 1980, eq. 8
constexpr double kLeastScatter_px = 1;
constexpr double kSamePosition_px = 1;  // nearer positions are the same

using Probabilities = std::vector<std::vector<double>>;  // of the candidates of each point; the rest: none is right

std::vector<std::vector<std::size_t>> neighbours_of(const std::vector<PointCandidates>& points, int count) {
  std::vector<std::vector<std::size_t>> out(points.size());
  std::vector<std::pair<double, std::size_t>> others;
  for (std::size_t i = 0; i < points.size(); ++i) {
    others.clear();
    for (std::size_t k = 0; k < points.size(); ++k)
      if (k != i && !points[k].candidates.empty())
        others.emplace_back((points[k].point_px - points[i].point_px).squaredNorm(), k);
    const auto wanted = std::min(std::size_t(count), others.size());
    std::partial_sort(others.begin(), others.begin() + std::ptrdiff_t(wanted), others.end());
    for (std::size_t k = 0; k < wanted; ++k) out[i].push_back(others[k].second);
  }
  return out;
}

Probabilities by_similarity(const std::vector<PointCandidates>& points) {
  Probabilities out(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    double best = 0, sum = 0;
    for (const CandidatePosition& candidate : points[i].candidates) {
      const double similarity = std::clamp(candidate.similarity, 0.0, 1.0);
      out[i].push_back(similarity);
      best = std::max(best, similarity);
      sum += similarity;
    }
    for (double& probability : out[i]) probability *= sum > 0 ? best / sum : 0;  // 1 - best: none is right
  }
  return out;
}

double support(const std::vector<PointCandidates>& points, const Probabilities& all, std::size_t i,
               const Eigen::Vector2d& parallax, const std::vector<std::size_t>& neighbours, double gradient) {
  double sum = 0;
  for (const std::size_t k : neighbours) {
    const PointCandidates& other = points[k];
    const double scatter = kLeastScatter_px + gradient * (other.point_px - points[i].point_px).norm();
    for (std::size_t m = 0; m < other.candidates.size(); ++m) {
      const double off = (other.candidates[m].position_px - other.expected_px - parallax).norm() / scatter;
      sum += all[k][m] * std::exp(-0.5 * off * off);
    }
  }
  return neighbours.empty() ? 0 : sum / double(neighbours.size());
}

RelaxedMatch decided(const std::vector<double>& probabilities, double least) {
  RelaxedMatch out;
  if (probabilities.empty()) return out;
  const auto best = std::max_element(probabilities.begin(), probabilities.end());
  out.probability = *best;
  out.outcome = RelaxedOutcome::kUndecided;
  if (!(*best >= least)) return out;
  out.outcome = probabilities.size() == 1 ? RelaxedOutcome::kOne : RelaxedOutcome::kChosen;
  out.candidate = std::size_t(best - probabilities.begin());
  return out;
}

// A position of the other image belongs to one point.
void make_unique(const std::vector<PointCandidates>& points, std::vector<RelaxedMatch>& matches) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (matches[i].candidate) order.push_back(i);
  const auto position = [&](std::size_t i) -> const Eigen::Vector2d& {
    return points[i].candidates[*matches[i].candidate].position_px;
  };
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return position(a).x() != position(b).x() ? position(a).x() < position(b).x() : a < b;
  });
  std::vector<bool> is_taken(matches.size(), false);
  for (std::size_t a = 0; a < order.size(); ++a)
    for (std::size_t b = a + 1; b < order.size() && position(order[b]).x() - position(order[a]).x() < kSamePosition_px;
         ++b) {
      if ((position(order[b]) - position(order[a])).norm() >= kSamePosition_px) continue;
      const bool first_is_better = matches[order[a]].probability >= matches[order[b]].probability;
      is_taken[first_is_better ? order[b] : order[a]] = true;
    }
  for (std::size_t i = 0; i < matches.size(); ++i)
    if (is_taken[i]) {
      matches[i].outcome = RelaxedOutcome::kTaken;
      matches[i].candidate.reset();
    }
}

}  // namespace

std::vector<RelaxedMatch> relax(const std::vector<PointCandidates>& points, const RelaxationOptions& options) {
  const auto neighbours = neighbours_of(points, options.neighbours);
  Probabilities now = by_similarity(points);
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    Probabilities next = now;
    for (std::size_t i = 0; i < points.size(); ++i) {
      double sum = 0, none = 1;
      for (std::size_t l = 0; l < now[i].size(); ++l) {
        const Eigen::Vector2d parallax = points[i].candidates[l].position_px - points[i].expected_px;
        none -= now[i][l];
        next[i][l] = now[i][l] *
                     (kKept + kSupported * support(points, now, i, parallax, neighbours[i], options.parallax_gradient));
        sum += next[i][l];
      }
      sum += std::max(none, 0.0);
      if (sum > 0)
        for (double& probability : next[i]) probability /= sum;
    }
    now = std::move(next);
  }
  std::vector<RelaxedMatch> out;
  for (const auto& probabilities : now) out.push_back(decided(probabilities, options.least_probability));
  make_unique(points, out);
  return out;
}

}  // namespace collinea
