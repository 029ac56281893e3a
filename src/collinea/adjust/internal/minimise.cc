// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/minimise.h"

#include <algorithm>
#include <cmath>

#include "collinea/adjust/internal/gauge.h"

namespace collinea::bundle {
namespace {

constexpr double kLeastDamping = 1e-12, kMostDamping = 1e12;

// The end is believed of a step with this damping of each diagonal element. What it holds back then is no more than
// that step, up to an inflation (Conditioning) of 1e8.
constexpr double kHardlyDamped = 1e-8;

// A gain by less than this part of the cost is small: the robust loss is then taken with its curvature, of which at
// least the second number stays.
constexpr double kNear = 0.05, kLeastCurvature = 0.1;

class LevenbergMarquardt {
 public:
  LevenbergMarquardt(Problem& problem, Normals& normals, const AdjustOptions& options, const Run& run)
      : problem_(problem),
        normals_(normals),
        options_(options),
        run_(run),
        hardly_damped_(std::max(kHardlyDamped, options.relative_cost_change)),
        damping_(options.first_damping) {}

  Minimum minimise(State start) {
    Minimum at{std::move(start)};
    const double by_gauge = settle_gauge(problem_, at.state);
    for (; at.iterations < options_.max_iterations && !at.converged && !run_.stopped(); ++at.iterations) {
      at.cost = normals_.accumulate(at.state, damping_, run_);
      if (at.iterations == 0) at.initial_cost = at.cost + by_gauge;
      if (is_exact(at)) {
        at.converged = true;
      } else if (!normals_.solve(run_, step_)) {
        if (!damp_more()) break;
      } else {
        State next = moved(problem_, at.state, damping_, step_, run_);
        measure_step(at);
        if (is_downhill(at))
          accept(at, std::move(next));
        else
          reject(at);
      }
    }
    return at;
  }

 private:
  /// The observations agree to rounding.
  [[nodiscard]] bool is_exact(const Minimum& at) const {
    return at.cost < 1e-20 * static_cast<double>(problem_.observation_count);
  }

  [[nodiscard]] bool is_downhill(const Minimum& at) const { return std::isfinite(step_.cost) && step_.cost < at.cost; }

  // Before the step is taken or not: its size, in units of what is known so far.
  void measure_step(Minimum& at) {
    tolerance_ = options_.relative_cost_change * at.cost;
    variance_ = at.cost / static_cast<double>(std::max(1L, problem_.redundancy()));
    at.last_step_sigmas = std::sqrt(std::max(0.0, step_.squared_length) / std::max(variance_, 1e-300));
    is_small_ = step_.largest_rotation_rad < options_.parameter_change &&
                step_.largest_move_m < options_.parameter_change * problem_.extent_m;
  }

  void accept(Minimum& at, State next) {
    const double before = at.cost, used = damping_;
    lower_damping(gain_ratio(before));
    at.state = std::move(next);
    const double by_gauge = settle_gauge(problem_, at.state);
    at.cost = step_.cost - by_gauge;
    end_or_confirm(at, is_at_rest(before, at.cost, by_gauge), used);
    if (before - at.cost < kNear * before) problem_.tie_loss.least_curvature = kLeastCurvature;
  }

  void reject(Minimum& at) {
    problem_.tie_loss.least_curvature = 1;
    at.converged = is_small_ || step_.promised <= tolerance_ * 1e-3 || !damp_more();
  }

  [[nodiscard]] double gain_ratio(double before) const { return (before - step_.cost) / step_.promised; }

  void lower_damping(double gain) {
    const double off = 2 * gain - 1;
    damping_ *= gain > 0.9 ? 0.1 : std::max(1.0 / 3, 1 - off * off * off);
    if (std::abs(gain - 1) < 0.01) damping_ = std::min(damping_, hardly_damped_);
    damping_ = std::max(damping_, kLeastDamping);
    growth_ = 2;
  }

  // False when there is nothing left to try. A step that was to confirm the one before made things worse: that one
  // needs its damping.
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

  // Steps of images and cameras say nothing where these are fixed: then only the cost does. Nor do they while the block
  // as a whole still moves.
  [[nodiscard]] bool is_at_rest(double before, double after, double by_gauge) const {
    const double shortest = options_.step_sigmas * options_.step_sigmas * variance_;
    const bool is_short = problem_.poses + problem_.global_count > 0 && step_.squared_length < shortest;
    const bool moved_as_one = by_gauge > std::max(tolerance_, shortest);
    return is_small_ || (!moved_as_one && (is_short || before - after <= tolerance_));
  }

  // At rest by a damped step: one that is hardly damped has to confirm it.
  void end_or_confirm(Minimum& at, bool at_rest, double used) {
    at.converged = at_rest && (used <= hardly_damped_ || needs_damping_);
    confirms_ = at_rest && !at.converged;
    if (!confirms_) return;
    damping_ = hardly_damped_;
    damping_before_ = used;
  }

  Problem& problem_;
  Normals& normals_;
  const AdjustOptions& options_;
  const Run& run_;
  const double hardly_damped_;  // who asks for little gets it by damped steps
  double damping_, growth_ = 2;
  bool confirms_ = false;       // this step is to tell whether the one before was short because of its damping
  double damping_before_ = 0;   // of that one
  bool needs_damping_ = false;  // such a step made things worse
  Step step_;                   // the step in work, and below what it is measured by
  double tolerance_ = 0, variance_ = 0;
  bool is_small_ = false;
};

}  // namespace

Minimum minimise(Problem& problem, Normals& normals, State start, const AdjustOptions& options, const Run& run) {
  return LevenbergMarquardt(problem, normals, options, run).minimise(std::move(start));
}

void settle_points(const Problem& problem, Minimum& found, const Run& run) {
  Step none;
  none.reduced.assign(static_cast<std::size_t>(6 * problem.poses + problem.global_count), 0.0);
  State settled = moved(problem, found.state, 0, none, run);
  if (!(none.cost < found.cost)) return;
  found.state = std::move(settled);
  found.cost = none.cost;
}

}  // namespace collinea::bundle
