// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/masked.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include "collinea/quality/internal/joint_tests.h"

namespace collinea {
namespace {

constexpr std::size_t kMostGiven = 80;
constexpr double kAsProbable = 14;  // twice the logarithm of the likelihood: a thousand times
constexpr double kSame = 0.99;      // correlation of the tests of two observations
constexpr double kControllable =
    0.002;  // least redundancy: all others have been looked at, unlike where Foerstner asks for 0.01

using Set = std::vector<std::size_t>;

bool is_given(ObservationGroup group) { return traits_of(group).source != ObservationSource::kTieImagePoint; }

// Coordinates that are fixed have no test; attitudes are no vectors.
bool can_be_tested(const Rejection& rejection) {
  const Rejected& one = rejection.rejected;
  if (!is_given(one.group) || traits_of(one.group).source == ObservationSource::kAttitude || !(rejection.sigma > 0))
    return false;
  return std::isfinite(one.w);
}

// What the others say of it is known.
bool can_be_healed(const Rejected& one) {
  const ObservationGroupTraits& traits = traits_of(one.group);
  return axes_of(one.group, one.gross_error).head(traits.axes).allFinite();
}

std::vector<std::size_t> rejected_given(const Remaining& remaining) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < remaining.rejections.size(); ++i)
    if (can_be_tested(remaining.rejections[i])) indices.push_back(i);
  return indices;
}

// Replaces a measurement by what the others say of it.
void heal(const Rejected& one, Block& block) {
  switch (traits_of(one.group).source) {
    case ObservationSource::kControlImagePoint:
      for (ControlObservation& seen : block.control_observations)
        if (seen.point == one.control && seen.image == one.image) seen.pixel -= one.gross_error.head<2>();
      return;
    case ObservationSource::kControlCoordinates:
      axes_of(one.group, block.control.at(one.control).position_in_world) -= axes_of(one.group, one.gross_error);
      return;
    case ObservationSource::kPosition:
      axes_of(one.group, block.images.at(one.image).position->position_in_world) -= axes_of(one.group, one.gross_error);
      return;
    case ObservationSource::kGeodetic:
      block.geodetic[one.geodetic].value -= one.gross_error.x();
      return;
    default:
      return;
  }
}

bool is_worth_a_look(std::size_t rejected, const SuspectChoice& last) {
  return rejected > 0 || std::ranges::any_of(last.kept, [](const KeptSuspect& one) {
           return is_given(one.observation.group) && std::isfinite(one.observation.w);
         });
}

// Without marks, which take part only as long as there is room.
std::size_t count_given(const Measurements& all) {
  std::size_t count = all.block.geodetic.size() + 2 * all.scope.attitudes.size();
  if (all.scope.use_control)
    for (const auto& [id, point] : all.block.control)
      if (point.role == ControlRole::kControl)
        count += point.sigma_m.head<2>().allFinite() + std::isfinite(point.sigma_m.z());
  if (all.scope.use_positions)
    for (const auto& [id, image] : all.block.images)
      if (image.position)
        count += image.position->sigma_m.head<2>().allFinite() + std::isfinite(image.position->sigma_m.z());
  return count;
}

ChosenSuspect suspect_of(const JointSystem& system, const JointOutcome& outcome, std::size_t measurement, double limit,
                         const Block& block) {
  ChosenSuspect chosen{.measurement = measurement_at(system.measurements[measurement], block)};
  for (int k = 0; k < system.size[measurement]; ++k) {
    const auto at = std::size_t(system.first[measurement] + k);
    const JointRow& row = system.rows[at];
    const JointOutcome::Test& test = outcome.tests[at];
    if (k > 0 && std::abs(test.w) <= std::abs(chosen.test.w)) continue;
    chosen.test.group = system.measurements[measurement].group;
    chosen.test.source = system.measurements[measurement].source;
    chosen.test.axis = row.axis;
    chosen.test.sigma = row.sigma;
    chosen.test.redundancy = test.redundancy;
    chosen.test.gross_error = test.gross_error;
    chosen.test.residual = test.redundancy * test.gross_error;
    chosen.test.w = chosen.test.suspicion = test.w;
    chosen.test.limit = limit;
  }
  return chosen;
}

class MaskedSearch {
 public:
  MaskedSearch(JointSystem system, double limit, const Block& block)
      : system_(std::move(system)), limit_(limit), block_(block) {}

  // False when nothing is to be said that was not said.
  bool choose(const std::vector<Measurement>& went, MaskedChoice& out) const {
    const std::vector<Explanation> found = explanations(system_, limit_);
    if (found.empty()) return false;
    const Set before = numbers_of(went);
    const double variance = std::pow(without_set(system_, found[0].set).sigma0, 2);
    const auto is_as_probable = [&](const Explanation& one) {
      return one.statistic > found[0].statistic - kAsProbable * variance;
    };
    const auto same = std::ranges::find(found, before, &Explanation::set);
    const bool is_right = same != found.end() && is_as_probable(*same);
    const Explanation& chosen = is_right ? *same : found[0];
    Set doubtful;
    for (const Explanation& other : found) {
      if (other.set == chosen.set || !is_as_probable(other) ||
          !(joint_correlation(system_, chosen.set, other.set) > kSame))
        continue;
      const Set one = only(chosen.set, other.set), instead = only(other.set, chosen.set);
      out.inseparable.push_back({names_of(one), names_of(instead)});
      if (are_of_one_point(one, instead)) continue;
      doubtful.insert(doubtful.end(), one.begin(), one.end());
      doubtful.insert(doubtful.end(), instead.begin(), instead.end());
    }
    if (is_right) return !out.inseparable.empty();
    if (doubtful.empty() && redundancy_of(system_, chosen.set) < kControllable) doubtful = chosen.set;
    std::ranges::sort(doubtful);
    const Set rejected = only(chosen.set, doubtful);
    // What stays though it is wrong spoils the tests of all others.
    out.is_undecided = !doubtful.empty();
    for (std::size_t one = 0; out.is_undecided && one < system_.measurements.size(); ++one)
      if (std::ranges::find(rejected, one) == rejected.end()) out.stays[name_of(one)] = StayReason::kSameDegree;
    const JointOutcome outcome = without_set(system_, chosen.set);
    for (const std::size_t one : rejected)
      out.choice.suspects.push_back(suspect_of(system_, outcome, one, limit_, block_));
    out.is_other = rejected != before;
    return out.is_other || !out.inseparable.empty();
  }

 private:
  [[nodiscard]] Measurement name_of(std::size_t one) const { return measurement_at(system_.measurements[one], block_); }
  [[nodiscard]] std::vector<Measurement> names_of(const Set& set) const {
    std::vector<Measurement> names;
    for (const std::size_t one : set) names.push_back(name_of(one));
    return names;
  }
  [[nodiscard]] Set numbers_of(const std::vector<Measurement>& names) const {
    Set numbers;
    for (std::size_t i = 0; i < system_.measurements.size(); ++i)
      if (std::ranges::find(names, name_of(i)) != names.end()) numbers.push_back(i);
    return numbers;
  }
  // A mark and the coordinates that it shows: whichever goes, the other says nothing of the rest.
  [[nodiscard]] bool are_of_one_point(const Set& one, const Set& other) const {
    std::set<ControlId> points;
    for (const Set* set : {&one, &other})
      for (const std::size_t i : *set) points.insert(name_of(i).control);
    return points.size() == 1 && points.begin()->valid();
  }
  static Set only(const Set& one, const Set& other) {
    Set rest;
    std::ranges::set_difference(one, other, std::back_inserter(rest));
    return rest;
  }

  const JointSystem system_;
  const double limit_;
  const Block& block_;
};

// The gross errors of what went, in a system of the healed block.
JointSystem with_gross_errors_of(JointSystem system, const Remaining& remaining,
                                 const std::vector<std::size_t>& indices, const Block& block) {
  std::vector<std::size_t> rows;
  std::vector<double> errors;
  for (std::size_t row = 0; row < system.rows.size(); ++row) {
    const Measurement name = measurement_at(system.measurements[system.rows[row].measurement], block);
    for (const std::size_t i : indices) {
      const Rejected& one = remaining.rejections[i].rejected;
      if (static_cast<const Measurement&>(one) != name) continue;
      rows.push_back(row);
      errors.push_back(one.gross_error[system.rows[row].axis]);
    }
  }
  return with_errors(std::move(system), rows, errors);
}

// By a system of all that was given, what went with the values of the others or as it was given.
bool choose_by(const Measurements& all, bool is_healed, const Remaining& remaining,
               const std::vector<std::size_t>& indices, const AdjustOptions& adjust, const Reliability& tests,
               const Run& run, MaskedChoice& out) {
  Measurements healed = all;
  std::vector<Measurement> went;
  for (const std::size_t i : indices) {
    went.push_back(remaining.rejections[i].rejected);
    if (is_healed) heal(remaining.rejections[i].rejected, healed.block);
  }
  AdjustOptions options = adjust;
  options.settle_points = true;
  Result<Solved> solved = solve_bundle(healed.block, healed.scope, options, run);
  if (!solved || !solved->estimate().converged) return false;
  const auto [factor, failed_row] = solved->factor(run);
  if (!factor) return false;
  JointSystem system = joint_system(*solved, *factor, kMostGiven, tests.sigma0_known, run);
  if (system.measurements.empty() || run.stopped()) return false;
  if (is_healed) system = with_gross_errors_of(std::move(system), remaining, indices, all.block);
  return MaskedSearch(std::move(system), tests.limit, all.block).choose(went, out);
}

}  // namespace

std::optional<MaskedChoice> masked_choice(const Remaining& remaining, const SuspectChoice& last,
                                          const AdjustOptions& adjust, const Reliability& tests, const Run& run) {
  const std::vector<std::size_t> indices = rejected_given(remaining);
  if (!is_worth_a_look(indices.size(), last) || count_given(remaining.measurements) > kMostGiven) return std::nullopt;
  MaskedChoice out{.before = put_back(remaining, indices)};
  const Measurements all = out.before.measurements;
  const bool is_known =
      std::ranges::all_of(indices, [&](std::size_t i) { return can_be_healed(remaining.rejections[i].rejected); });
  if (is_known && choose_by(all, true, remaining, indices, adjust, tests, run, out)) return out;
  // Where much has gone that was right the others may say little of it.
  if ((indices.size() > 2 || !is_known) && choose_by(all, false, remaining, indices, adjust, tests, run, out))
    return out;
  return std::nullopt;
}

}  // namespace collinea
