// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/bundle.h"

#include <string>
#include <utility>

#include "collinea/adjust/gather.h"
#include "collinea/adjust/internal/kept_factor.h"
#include "collinea/adjust/internal/minimise.h"
#include "collinea/adjust/internal/normals.h"
#include "collinea/adjust/outcome.h"

namespace collinea {

using bundle::KeptFactor;
using bundle::Minimum;
using bundle::Normals;
using bundle::Problem;

Result<Adjusted> adjust(const Block& block, const AdjustScope& scope, const AdjustOptions& options, const Run& run) {
  return Adjuster().adjust(block, scope, options, run);
}

Result<Solved> solve_bundle(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                            const Run& run) {
  return Adjuster().solve(block, scope, options, run);
}

Adjuster::Adjuster() = default;
Adjuster::~Adjuster() = default;
Adjuster::Adjuster(const Adjuster&) {}
Adjuster& Adjuster::operator=(const Adjuster&) {
  kept_.reset();
  return *this;
}
Adjuster::Adjuster(Adjuster&&) noexcept = default;
Adjuster& Adjuster::operator=(Adjuster&&) noexcept = default;

Result<Adjusted> Adjuster::adjust(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                                  const Run& run) {
  COLLINEA_TRY(Solved solved, solve(block, scope, options, run));
  return solved.take_estimate();
}

Result<Solved> Adjuster::solve(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                               const Run& run) {
  if (Result<> valid = validate(options); !valid) return tl::unexpected(std::move(valid).error().within("adjustment"));
  COLLINEA_TRY(bundle::ProblemAndStart gathered, bundle::gather(block, scope, options));
  auto problem = std::make_unique<Problem>(std::move(gathered.problem));
  if (problem->redundancy() < 0)
    return fail(Errc::kIllPosed, std::to_string(problem->unknown_count) + " unknowns but only " +
                                     std::to_string(problem->observation_count) +
                                     " observations: the block cannot be adjusted");
  if (!kept_) kept_ = std::make_shared<KeptFactor>();
  auto normals = std::make_unique<Normals>(*problem, *kept_);
  Minimum found = bundle::minimise(*problem, *normals, std::move(gathered.start), options, run);
  if (run.stopped()) return fail(Errc::kCancelled, "bundle adjustment stopped");
  problem->tie_loss.least_curvature = 1;  // statistics are those of the weights
  if (options.settle_points) bundle::settle_points(*problem, found, run);

  Adjusted adjusted;
  adjusted.initial_cost = found.initial_cost;
  adjusted.final_cost = found.cost;
  adjusted.iterations = found.iterations;
  adjusted.converged = found.converged;
  adjusted.last_step_sigmas = found.last_step_sigmas;
  bundle::describe_outcome(block, scope, *problem, found.state, adjusted);
  return Solved(block, std::move(problem), std::move(found.state), kept_, std::move(normals), std::move(adjusted));
}

}  // namespace collinea
