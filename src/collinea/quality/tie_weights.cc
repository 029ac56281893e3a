// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/tie_weights.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/base/parallel.h"
#include "collinea/quality/internal/point_rays.h"

namespace collinea {
namespace {

constexpr int kMostRounds = 8;
constexpr double kUnchanged = 0.02;

// The error of each observation in standard deviations `stated`; no directions where nothing checks it.
struct RayErrors {
  std::vector<CheckedError> of;  // each of Block::observations
  std::vector<RayError> counted;
};

RayErrors errors_of(const Solved& solved, const std::vector<double>& stated, const Run& run) {
  const bundle::Problem& problem = solved.problem();
  const std::vector<Observation>& observations = solved.block().observations;
  std::vector<std::size_t> ties;
  for (std::size_t p = 0; p < problem.point_count(); ++p)
    if (problem.point(p).control < 0) ties.push_back(p);
  RayErrors found;
  found.of.resize(observations.size());
  std::vector<std::uint8_t> rays(observations.size(), 0);
  std::vector<char> is_second(observations.size(), 0);
  parallel_for(run, ties.size(), [&](std::size_t i) {
    const PointRays point(problem, solved.state(), ties[i]);
    const std::vector<CheckedError> errors = point.errors();
    for (std::size_t k = 0; k < errors.size(); ++k) {
      const std::uint32_t source = point.source(k);
      const double factor = observations[source].sigma_px / stated[source];
      found.of[source] = {factor * factor * errors[k].squared, errors[k].directions};
      rays[source] = std::uint8_t(std::min<std::size_t>(errors.size(), 255));
      is_second[source] = errors.size() == 2 && k == 1;  // says the same as the first
    }
  });
  for (std::size_t i = 0; i < observations.size(); ++i)
    if (rays[i] > 0 && !is_second[i]) found.counted.push_back({found.of[i], rays[i]});
  return found;
}

// Sets the sigmas by the errors; answers the root mean square of the change of their logarithms.
double set_sigmas(const RayErrors& errors, const std::vector<double>& stated, TieWeights& found, Block& block) {
  const double nu = found.degrees_of_freedom;
  std::vector<double> weights(stated.size(), 1);
  double squares = 0, directions = 0;
  for (std::size_t i = 0; i < stated.size(); ++i) {
    const CheckedError& error = errors.of[i];
    if (error.directions == 0) continue;
    weights[i] = (nu + error.directions) / (nu + error.squared / (found.scale * found.scale));
    squares += weights[i] * error.squared;
    directions += error.directions;
  }
  const double scale = std::sqrt(squares / directions);  // so that sigma0 is 1
  double changes = 0;
  for (std::size_t i = 0; i < stated.size(); ++i) {
    const double sigma = stated[i] * scale / std::sqrt(weights[i]);
    changes += std::pow(std::log(sigma / block.observations[i].sigma_px), 2);
    block.observations[i].sigma_px = sigma;
  }
  std::sort(weights.begin(), weights.end());
  found.least = weights.front();
  found.lower_quartile = weights[weights.size() / 4];
  return std::sqrt(changes / double(stated.size()));
}

}  // namespace

Result<TieWeights> weigh_ties(Block& block, const AdjustScope& scope, const AdjustOptions& options, const Run& run) {
  TieWeights found;
  found.degrees_of_freedom = std::numeric_limits<double>::infinity();
  std::vector<double> stated;
  for (const Observation& seen : block.observations) stated.push_back(seen.sigma_px);
  AdjustOptions least_squares = options;
  least_squares.loss = Loss::kNone;
  Adjuster adjuster;
  const AdjustScope around = with_first_cameras(scope, block.cameras);
  for (found.converged = false; found.rounds < kMostRounds && !found.converged;) {
    RayErrors errors;
    {
      COLLINEA_TRY(Solved solved, adjuster.solve(block, around, least_squares, run));
      errors = errors_of(solved, stated, run);
      if (run.stopped()) return fail(Errc::kCancelled, "weighting of tie points stopped");
      apply(solved.estimate(), block);
    }
    ++found.rounds;
    if (found.rounds == 1) {
      found.errors = fit_tie_errors(errors.counted);
      const auto loss = loss_of(found.errors);
      if (!loss || loss->loss == Loss::kNone) {
        found.converged = true;
        return found;
      }
      found.degrees_of_freedom = loss->loss_scale_sigmas * loss->loss_scale_sigmas - 2;
      found.scale = loss->sigma_factor * std::sqrt(1 + 2 / found.degrees_of_freedom);
    }
    found.converged = set_sigmas(errors, stated, found, block) < kUnchanged;
  }
  return found;
}

}  // namespace collinea
