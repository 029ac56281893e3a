// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/bundle.h"

#include <algorithm>
#include <cmath>

#include "collinea/adjust/gauge.h"
#include "collinea/adjust/normals.h"
#include "collinea/adjust/outcome.h"

namespace collinea {
namespace {

using bundle::Normals;
using bundle::Problem;
using bundle::State;
using bundle::Step;

constexpr double kLeastDamping = 1e-12, kMostDamping = 1e12;

// Of a diagonal element of the normal equations. A damped step is short where little determines the block, however far
// it still has to go: the end is believed of a step with this damping. What it holds back then is no more than that
// step, up to an inflation (Conditioning) of 1e8.
constexpr double kHardlyDamped = 1e-8;

// Once a step gains less than this part, the robust loss is taken with its curvature: reweighting alone creeps.
constexpr double kNear = 0.05, kLeastCurvature = 0.1;

struct Search {
  State state;
  double initial_cost = 0, cost = 0;
  int iterations = 0;
  bool converged = false;
  double last_step = 0;  // in standard deviations
};

/// Levenberg-Marquardt with the gain ratio of Madsen, Nielsen, Tingleff (2004); a step that the linear model foretold
/// well lowers the damping tenfold, one that it foretold to a hundredth ends it.
class LevenbergMarquardt {
 public:
  LevenbergMarquardt(Problem& problem, Normals& normals, const AdjustOptions& options, const Run& run)
      : problem_(problem),
        normals_(normals),
        options_(options),
        run_(run),
        hardly_damped_(std::max(kHardlyDamped, options.relative_cost_change)),
        damping_(options.first_damping) {}

  Search search(State start) {
    Search at{std::move(start)};
    const double settled = bundle::settle_gauge(problem_, at.state);
    for (; at.iterations < options_.max_iterations && !at.converged && !run_.stopped(); ++at.iterations) {
      at.cost = normals_.accumulate(at.state, damping_, run_);
      if (at.iterations == 0) at.initial_cost = at.cost + settled;
      if (at.cost < 1e-20 * static_cast<double>(problem_.observation_count)) at.converged = true;
      if (at.converged) continue;
      if (!normals_.solve(run_, step_)) {
        if (!damp_more()) break;
        continue;
      }
      State next = bundle::moved(problem_, at.state, damping_, step_, run_);
      judge(at, std::move(next));
    }
    return at;
  }

 private:
  bool damp_more() {
    if (confirms_) {
      needs_damping_ = true;
      damping_ = damping_before_;
      confirms_ = false;
      return true;
    }
    damping_ *= growth_;
    growth_ *= 2;
    return damping_ < kMostDamping;
  }

  void judge(Search& at, State next) {
    const double tolerance = options_.relative_cost_change * at.cost;
    const double variance = at.cost / static_cast<double>(std::max(1L, problem_.redundancy()));
    at.last_step = std::sqrt(std::max(0.0, step_.squared_length) / std::max(variance, 1e-300));
    // Steps of images and cameras say nothing where these are held: then only the cost does.
    const bool short_step = problem_.poses + problem_.border > 0 &&
                            step_.squared_length < options_.step_sigmas * options_.step_sigmas * variance;
    const bool small = step_.largest_turn_rad < options_.parameter_change &&
                       step_.largest_move_m < options_.parameter_change * problem_.extent_m;
    if (std::isfinite(step_.cost) && step_.cost < at.cost) {
      const double before = at.cost, gain = (before - step_.cost) / step_.promised, used = damping_;
      const double bend = 2 * gain - 1;
      damping_ *= gain > 0.9 ? 0.1 : std::max(1.0 / 3, 1 - bend * bend * bend);
      if (std::abs(gain - 1) < 0.01) damping_ = std::min(damping_, hardly_damped_);
      damping_ = std::max(damping_, kLeastDamping);
      growth_ = 2;
      at.state = std::move(next);
      const double by_gauge = bundle::settle_gauge(problem_, at.state);
      at.cost = step_.cost - by_gauge;
      const bool moved_as_one = by_gauge > std::max(tolerance, options_.step_sigmas * options_.step_sigmas * variance);
      const bool at_rest = small || (!moved_as_one && (short_step || before - at.cost <= tolerance));
      at.converged = at_rest && (used <= hardly_damped_ || needs_damping_);
      confirms_ = at_rest && !at.converged;
      if (confirms_) {
        damping_ = hardly_damped_;
        damping_before_ = used;
      }
      if (before - at.cost < kNear * before) problem_.tie_loss.least_curvature = kLeastCurvature;
    } else {
      problem_.tie_loss.least_curvature = 1;
      at.converged = small || step_.promised <= tolerance * 1e-3 || !damp_more();
    }
  }

  Problem& problem_;
  Normals& normals_;
  const AdjustOptions& options_;
  const Run& run_;
  Step step_;
  const double hardly_damped_;  // who asks for little gets it by damped steps
  double damping_, growth_ = 2;
  bool confirms_ = false;       // this step is to tell whether the one before was short because of its damping
  double damping_before_ = 0;   // of that one
  bool needs_damping_ = false;  // such a step made things worse
};

// Brings every point to its place, images and cameras as they are. The iterations end when these are at rest: a point
// with far to go (one ray and coarse coordinates) may still be off by some of its sigmas, which would be taken for a
// blunder where hardly anything checks it.
void place_points(const Problem& problem, Search& found, const Run& run) {
  Step none;
  none.reduced.assign(static_cast<std::size_t>(6 * problem.poses + problem.border), 0.0);
  State placed = bundle::moved(problem, found.state, 0, none, run);
  if (!(none.cost < found.cost)) return;
  found.state = std::move(placed);
  found.cost = none.cost;
}

}  // namespace

Result<Adjusted> adjust(const Block& block, const AdjustScope& scope, const AdjustOptions& options, const Run& run) {
  return Adjuster().adjust(block, scope, options, run);
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
  if (Result<> valid = validate(options); !valid) return tl::unexpected(std::move(valid).error().within("adjustment"));
  COLLINEA_TRY(bundle::ProblemAndStart gathered, bundle::gather(block, scope, options));
  Problem& problem = gathered.problem;
  if (problem.redundancy() < 0)
    return fail(Errc::kIllPosed, std::to_string(problem.unknown_count) + " unknowns but only " +
                                     std::to_string(problem.observation_count) +
                                     " observations: the block cannot be adjusted");
  if (!kept_) kept_ = std::make_unique<bundle::KeptFactor>();
  Normals normals(problem, *kept_);
  Search found = LevenbergMarquardt(problem, normals, options, run).search(std::move(gathered.start));
  if (run.stopped()) return fail(Errc::kCancelled, "bundle adjustment stopped");
  problem.tie_loss.least_curvature = 1;  // statistics are those of the weights
  if (options.reliability) place_points(problem, found, run);

  Adjusted adjusted;
  adjusted.initial_cost = found.initial_cost;
  adjusted.final_cost = found.cost;
  adjusted.iterations = found.iterations;
  adjusted.converged = found.converged;
  adjusted.last_step_sigmas = found.last_step;
  bundle::describe_outcome(block, scope, problem, found.state, adjusted);
  if (options.covariances || options.point_covariances || options.reliability) {
    bundle::add_covariances(block, problem, found.state, options, run, normals, adjusted);
    if (run.stopped()) return fail(Errc::kCancelled, "bundle adjustment stopped");
  }
  return adjusted;
}

void apply(const Adjusted& adjusted, Block& block) {
  for (const auto& [id, pose] : adjusted.cam_from_world) set_pose(block, id, pose);
  for (const auto& [id, camera] : adjusted.cameras) block.cameras[id] = camera;
  auto known = block.points.begin();
  for (const auto& [id, position] : adjusted.points) {
    if (known != block.points.end() && known->first < id) ++known;
    if (known == block.points.end() || known->first != id) known = block.points.lower_bound(id);
    if (known != block.points.end() && known->first == id) known->second.position_in_world = position;
  }
}

}  // namespace collinea
