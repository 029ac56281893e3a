// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/neighbour_matching.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/base/parallel.h"
#include "collinea/match/rank_covariance.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kMostCandidates = 8;
constexpr double kMostCertain = 0.999;  // of likenesses as probabilities: even a perfect copy may be another one

// The candidates of a point as area matching measures them.
struct Measured {
  AreaOutcome outcome = AreaOutcome::kOutside;
  std::vector<AreaMatch> matches;
  std::vector<Eigen::Vector2i> pixels;
  std::vector<double> likeness;
};

// `decisive_ratio` tells the rivals from what the best is decisively better than.
Measured measured(const GreyImage& image, const GreyImage& other, const AreaPoint& point, const AreaOptions& options,
                  double decisive_ratio) {
  const AreaMatching matching =
      match_area(image, point.position_px, other, point.searched_px.value_or(point.expected_px), options);
  Measured out{matching.outcome, {}, {}, {}};
  const std::vector<double> likeness = likenesses(matching.surface, matching.candidates);
  const Vector2d in_pixel = point.position_px - point.position_px.array().floor().matrix();
  const std::size_t count = rivals(matching.surface, matching.candidates, decisive_ratio);
  for (std::size_t i = 0; i < count && out.matches.size() < kMostCandidates; ++i) {
    const AreaCandidate& candidate = matching.candidates[i];
    const auto peak = subpixel_peak(matching.surface, candidate.pixel);
    if (!peak) continue;
    out.matches.push_back({candidate.pixel.cast<double>() + in_pixel + peak->offset_px, peak->covariance_px2,
                           candidate.value, std::nullopt});
    out.pixels.push_back(candidate.pixel);
    out.likeness.push_back(likeness[i]);
  }
  return out;
}

NeighbourMatch decided(const Measured& point, const RelaxedMatch& decision) {
  NeighbourMatch out{point.outcome, std::nullopt, point.matches.size(), 0, decision.probability};
  switch (decision.outcome) {
    case RelaxedOutcome::kNoCandidate:  // beyond the images, below the threshold, or at the border of the search
      if (out.outcome == AreaOutcome::kFound || out.outcome == AreaOutcome::kAmbiguous)
        out.outcome = AreaOutcome::kAtBorder;
      break;
    case RelaxedOutcome::kUndecided:
      out.outcome = AreaOutcome::kUndecided;
      break;
    case RelaxedOutcome::kTaken:
      out.outcome = AreaOutcome::kTaken;
      break;
    default:
      out.outcome = AreaOutcome::kFound;
      out.match = point.matches[*decision.candidate];
      out.likeness = point.likeness[*decision.candidate];
  }
  return out;
}

}  // namespace

std::vector<double> likenesses(const CorrelationSurface& surface, std::span<const AreaCandidate> of) {
  std::vector<double> out;
  const auto left_over = [&](double value) { return surface.method == Similarity::kCosine ? 1 - value : value; };
  const double at_random = of.empty() ? 0 : left_over(median(std::vector(surface.values.data)));
  for (const AreaCandidate& candidate : of) {
    const double part = at_random > 0 ? std::clamp(left_over(candidate.value) / at_random, 0.0, 1.0) : 1;
    switch (surface.method) {
      case Similarity::kNcc:
        out.push_back(std::clamp(candidate.value, 0.0, 1.0));
        break;
      case Similarity::kCosine:
      case Similarity::kSsd:
        out.push_back(1 - part);
        break;
      case Similarity::kCensus:
        out.push_back(part < 1 ? std::cos(std::numbers::pi / 2 * part) : 0);
        break;
      default:
        out.push_back(1 - part * part);
    }
  }
  return out;
}

std::vector<NeighbourMatch> match_areas(const GreyImage& image, const GreyImage& other,
                                        std::span<const AreaPoint> points, const AreaOptions& options,
                                        const RelaxationOptions& relaxation, const Run& run) {
  AreaOptions all = options;  // the candidates are wanted, not the decision
  all.return_px.reset();
  all.decisive_ratio = 1;
  std::vector<Measured> found(points.size());
  parallel_for(run, points.size(),
               [&](std::size_t i) { found[i] = measured(image, other, points[i], all, options.decisive_ratio); });
  std::vector<PointCandidates> asked(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    asked[i] = {points[i].position_px, points[i].expected_px, {}};
    for (std::size_t k = 0; k < found[i].matches.size(); ++k)
      asked[i].candidates.push_back({found[i].matches[k].position_px, std::min(found[i].likeness[k], kMostCertain)});
  }
  const std::vector<RelaxedMatch> decisions = relax(asked, relaxation);
  std::vector<NeighbourMatch> out(points.size());
  parallel_for(run, points.size(), [&](std::size_t i) {
    out[i] = decided(found[i], decisions[i]);
    if (!out[i].match || out[i].match->covariance_px2) return;
    const Eigen::Vector2i middle = points[i].position_px.array().floor().matrix().cast<int>();
    out[i].match->covariance_px2 =
        rank_covariance(image, middle, options.template_px / 2, other, found[i].pixels[*decisions[i].candidate],
                        options.method, options.neighbourhood_px);
  });
  return out;
}

}  // namespace collinea
