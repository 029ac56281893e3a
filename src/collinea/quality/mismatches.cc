// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/mismatches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "collinea/base/parallel.h"
#include "collinea/math/median.h"
#include "collinea/quality/internal/point_rays.h"

namespace collinea {
namespace {

constexpr int kPasses =
    4;  // fits of the distribution, from the second on without the influence of mismatches on others
constexpr double kNoBound = std::numeric_limits<double>::infinity();
constexpr double kMoreProbableThanNot = 0.5;
constexpr double kThreeSigmas2 = 2 * 9;   // of the difference of two tests: its variance is 2 (1 - rho)
constexpr double kManyMismatches = 0.01;  // of the rays: poses may have followed them
constexpr int kMostRounds = 2;
constexpr std::size_t kFewestMeasurements = 500;
constexpr double kFarOff = 10, kLeastSigma = 1e-3;  // robust standard deviations; the least of them, in given ones
constexpr double kMedianOfTwo = 1.1774;             // median of the length of a normal 2-vector

// A tie point with its rays. What is found of it belongs to it alone.
struct ExaminedPoint {
  PointRays rays;
  std::vector<CheckedError> errors;  // of all rays, those that are wrong among them
  double worst = 0;                  // the probability of its worst ray
  std::vector<std::uint32_t> wrong, with_them;
  std::vector<double> probabilities;  // of `wrong`
  std::vector<RayError> separated;    // errors without the influence of wrong rays on the others
};

std::size_t worst_of(const std::vector<CheckedError>& errors) {
  const auto worst = std::max_element(errors.begin(), errors.end(),
                                      [](const auto& a, const auto& b) { return a.squared < b.squared; });
  return static_cast<std::size_t>(worst - errors.begin());
}

// Both rays of a point with two say the same, which counts once.
void append(const std::vector<CheckedError>& errors, std::vector<RayError>& all) {
  const std::size_t count = errors.size() == 2 ? 1 : errors.size();
  for (std::size_t i = 0; i < count; ++i) all.push_back({errors[i], static_cast<int>(errors.size())});
}

double worst_probability(const std::vector<CheckedError>& errors, const TieErrors& distribution) {
  const ErrorDistribution* of = distribution.of(static_cast<int>(errors.size()));
  return of && !errors.empty() ? of->gross_probability(errors[worst_of(errors)]) : 0;
}

// Rays that may be wrong in the place of the worst.
std::vector<std::size_t> alternatives(const std::vector<CheckedError>& errors, std::size_t worst, double scale) {
  std::vector<std::size_t> found;
  const double most = std::sqrt(errors[worst].squared);
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (i != worst && most * (most - std::sqrt(errors[i].squared)) < kThreeSigmas2 * scale * scale) found.push_back(i);
  return found;
}

// What the first separation goes by. Mismatches enlarge the errors of the other rays of their points, which then look
// like long tails; if such are there, they show again in what is separated.
TieErrors with_short_tails(TieErrors fitted) {
  constexpr double kLeastDegrees = 4, kLeastShare = 0.02;
  for (TieErrors::Class& one : fitted.classes) {
    if (one.distribution.degrees_of_freedom >= kLeastDegrees) continue;
    one.distribution.degrees_of_freedom = kLeastDegrees;
    one.distribution.gross_share = std::max(one.distribution.gross_share, kLeastShare);
  }
  return fitted;
}

bool has_gross(const TieErrors& fitted) {
  return std::ranges::any_of(fitted.classes, [](const auto& one) { return one.distribution.gross_share > 0; });
}

// Rejects its wrong rays one after the other.
void separate(const TieErrors& distribution, double least_probability, ExaminedPoint& point) {
  point.wrong.clear();
  point.with_them.clear();
  point.probabilities.clear();
  point.separated.clear();
  PointRays rays = point.rays;
  std::vector<CheckedError> errors = point.errors;
  while (!errors.empty()) {
    const std::size_t worst = worst_of(errors);
    const ErrorDistribution& of = *distribution.of(static_cast<int>(errors.size()));
    const double probability = of.gross_probability(errors[worst]);
    if (probability <= least_probability) break;
    point.wrong.push_back(rays.source(worst));
    point.probabilities.push_back(probability);
    point.separated.push_back({errors[worst], static_cast<int>(errors.size())});
    std::vector<std::size_t> going = alternatives(errors, worst, of.scale);
    for (const std::size_t i : going) point.with_them.push_back(rays.source(i));
    going.push_back(worst);
    std::sort(going.rbegin(), going.rend());
    for (const std::size_t i : going) rays.leave_out(i);
    errors = rays.errors();
    if (rays.size() == 1) {
      point.with_them.push_back(rays.source(0));
      errors.clear();
    }
  }
  append(errors, point.separated);
}

class MismatchFinder {
 public:
  MismatchFinder(const Solved& solved, const Run& run) : run_(run) {
    const bundle::Problem& problem = solved.problem();
    std::vector<std::size_t> ties;
    for (std::size_t p = 0; p < problem.point_count(); ++p)
      if (problem.point(p).control < 0) ties.push_back(p);
    points_.resize(ties.size());
    parallel_for(run, ties.size(), [&](std::size_t i) {
      points_[i].emplace(ExaminedPoint{.rays = PointRays(problem, solved.state(), ties[i])});
      points_[i]->errors = points_[i]->rays.errors();
      append(points_[i]->errors, points_[i]->separated);
    });
  }

  Mismatches find(double false_alarm) {
    Mismatches found;
    if (run_.stopped()) return found;
    found.errors = fit();
    for (const auto& point : points_) found.tested += static_cast<long>(point->errors.size());
    separate_all(with_short_tails(found.errors), kNoBound);
    for (int pass = 1; pass < kPasses; ++pass) {
      found.errors = fit();
      const bool is_last = pass + 1 == kPasses || !has_gross(found.errors);
      separate_all(found.errors, is_last ? false_alarm * static_cast<double>(found.tested) : kNoBound);
      if (is_last) break;
    }
    for (const auto& point : points_) {
      found.wrong.insert(found.wrong.end(), point->wrong.begin(), point->wrong.end());
      found.with_them.insert(found.with_them.end(), point->with_them.begin(), point->with_them.end());
      for (const double probability : point->probabilities) found.expected_good += 1 - probability;
    }
    std::sort(found.wrong.begin(), found.wrong.end());
    std::sort(found.with_them.begin(), found.with_them.end());
    return found;
  }

 private:
  [[nodiscard]] TieErrors fit() const {
    std::vector<RayError> errors;
    for (const auto& point : points_) errors.insert(errors.end(), point->separated.begin(), point->separated.end());
    return fit_tie_errors(errors);
  }

  void separate_all(const TieErrors& distribution, double most_good) {
    if (distribution.classes.empty()) return;
    std::vector<double> probabilities;
    for (auto& point : points_) {
      point->worst = worst_probability(point->errors, distribution);
      if (point->worst > kMoreProbableThanNot) probabilities.push_back(point->worst);
    }
    std::sort(probabilities.rbegin(), probabilities.rend());
    double least = kMoreProbableThanNot, good = 0;
    for (const double probability : probabilities)
      if ((good += 1 - probability) > most_good) {
        least = probability;
        break;
      }
    parallel_for(run_, points_.size(), [&](std::size_t i) {
      if (points_[i]->worst > least || !points_[i]->wrong.empty()) separate(distribution, least, *points_[i]);
    });
  }

  const Run& run_;
  std::vector<std::optional<ExaminedPoint>> points_;
};

// Without these observations, and without points that lost some and have fewer than two left.
void reject(const Mismatches& found, Block& block) {
  std::vector<bool> goes(block.observations.size(), false);
  std::map<PointId, int> left;
  for (const auto* rays : {&found.wrong, &found.with_them})
    for (const std::uint32_t i : *rays) {
      goes[i] = true;
      left[block.observations[i].point] = 0;
    }
  for (std::size_t i = 0; i < goes.size(); ++i)
    if (const auto point = left.find(block.observations[i].point); point != left.end() && !goes[i]) ++point->second;
  std::vector<Observation> staying;
  staying.reserve(block.observations.size());
  for (std::size_t i = 0; i < goes.size(); ++i) {
    const auto point = left.find(block.observations[i].point);
    if (!goes[i] && (point == left.end() || point->second >= 2)) staying.push_back(block.observations[i]);
  }
  block.observations = std::move(staying);
  for (const auto& [point, rays] : left)
    if (rays < 2) block.points.erase(point);
}

// What is found in a later round, by the indices of the first.
void add(const Mismatches& later, const std::vector<std::uint32_t>& first_index, Mismatches& all) {
  const auto move = [&](const std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to) {
    for (const std::uint32_t i : from) to.push_back(first_index[i]);
    std::sort(to.begin(), to.end());
  };
  move(later.wrong, all.wrong);
  move(later.with_them, all.with_them);
  all.expected_good += later.expected_good;
  all.errors = later.errors;
}

// Indices of observations that stay, in their order.
std::vector<std::uint32_t> staying(const Block& before, const Block& after) {
  std::vector<std::uint32_t> indices;
  std::size_t next = 0;
  for (std::uint32_t i = 0; i < before.observations.size() && next < after.observations.size(); ++i) {
    const Observation &one = before.observations[i], &left = after.observations[next];
    if (one.point != left.point || one.image != left.image || one.pixel != left.pixel) continue;
    indices.push_back(i);
    ++next;
  }
  return indices;
}

AdjustOptions robust(AdjustOptions options) {
  if (options.loss == Loss::kNone) {
    options.loss = Loss::kHuber;
    options.loss_scale_sigmas = 2;
  }
  options.relative_cost_change = std::max(options.relative_cost_change, 1e-5);
  options.step_sigmas = std::max(options.step_sigmas, 0.1);
  return options;
}

}  // namespace

Mismatches find_mismatches(const Solved& solved, double false_alarm, const Run& run) {
  return MismatchFinder(solved, run).find(false_alarm);
}

std::optional<Finding> mismatches_left(const Block& block, const Adjusted& adjusted) {
  std::vector<double> sizes;  // in the sigmas given
  for (std::size_t i = 0; i < adjusted.observations.size(); ++i)
    if (const double size = adjusted.residuals_px[i].norm(); std::isfinite(size))
      sizes.push_back(size / block.observations[adjusted.observations[i]].sigma_px);
  if (sizes.size() < kFewestMeasurements) return std::nullopt;
  const double limit = kFarOff * std::max(kLeastSigma, median(std::vector(sizes)) / kMedianOfTwo);
  const auto far = std::ranges::count_if(sizes, [&](double size) { return size > limit; });
  const double share = static_cast<double>(far) / static_cast<double>(sizes.size());
  if (share <= kManyMismatches) return std::nullopt;
  return finding_of(FindingCode::kMismatchesLeft, {},
                    {{FigureName::kCount, static_cast<double>(far)},
                     {FigureName::kOf, static_cast<double>(sizes.size())},
                     {FigureName::kShare, share}},
                    {OptionName{"reject_mismatches", "adjust", "yes"}});
}

Result<WithoutMismatches> reject_mismatches(Block block, const AdjustScope& scope, const AdjustOptions& options,
                                            double false_alarm, const Run& run) {
  Adjuster adjuster;
  WithoutMismatches result{.block = std::move(block)};
  const Block before = result.block;
  const AdjustScope around = with_first_cameras(scope, before.cameras);
  for (double part = 1; result.rounds < kMostRounds && part > kManyMismatches; ++result.rounds) {
    Mismatches found;
    {
      COLLINEA_TRY(Solved solved, adjuster.solve(result.block, around, robust(options), run));
      found = find_mismatches(solved, false_alarm, run);
      if (run.stopped()) return fail(Errc::kCancelled, "search for mismatches stopped");
      apply(solved.estimate(), result.block);
    }
    part = found.tested > 0 ? static_cast<double>(found.size()) / static_cast<double>(found.tested) : 0;
    if (result.rounds == 0)
      result.found = found;
    else
      add(found, staying(before, result.block), result.found);
    if (found.size() > 0) reject(found, result.block);
  }
  return result;
}

}  // namespace collinea
