// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/control_doubt.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr ObservationSource kSource = ObservationSource::kControlCoordinates;
constexpr double kSettled = 1.2;  // a few points do not tell their sigma any better
constexpr double kStep = 5;       // one step does no more: weights must not collapse

// Sums over coordinates of the control points, for their variance components (see quality/variance_components.h).
struct Shown {
  double squares = 0, redundancy = 0;  // of residuals in sigmas; what the block and the other points know of them
  int coordinates = 0;
  // The factor of control that positions alone contradict is not known: their errors are mostly common to all.
  [[nodiscard]] double sigma_factor(ObservationGroup group) const {
    const int of_datum = group == ObservationGroup::kControlPlan ? 4 : 3;
    return coordinates > of_datum && squares > 0 && redundancy > 0 ? std::sqrt(squares / redundancy) : 1;
  }
};
using ShownByGroup = std::map<ObservationGroup, Shown>;

ShownByGroup shown_by_coordinates(const Block& setup, const Adjusted& adjusted) {
  ShownByGroup shown;
  for (const ObservationGroup group : groups_of(kSource)) shown[group] = {};
  for (const ControlDifference& control : adjusted.control) {
    if (!control.used || !control.covariance_m2) continue;
    const Eigen::Vector3d& sigma_m = setup.control.at(control.point).sigma_m;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(sigma_m[axis] > 0 && std::isfinite(sigma_m[axis]))) continue;  // fixed: nothing shows
      Shown& its = shown[group_of(kSource, axis)];
      ++its.coordinates;
      its.squares += std::pow(control.difference_m[axis] / sigma_m[axis], 2);
      its.redundancy += 1 - (*control.covariance_m2)(axis, axis) / (sigma_m[axis] * sigma_m[axis]);
    }
  }
  return shown;
}

}  // namespace

double control_misfit(const Block& setup, const Adjusted& adjusted) {
  double sum = 0, largest = 0;
  for (const auto& [group, shown] : shown_by_coordinates(setup, adjusted)) {
    sum += shown.squares;
    if (shown.redundancy >= kLeastRedundancy) largest = std::max(largest, shown.sigma_factor(group));
  }
  int measured = 0;
  std::set<ControlId> used;
  for (const ControlDifference& difference : adjusted.control) {
    if (!difference.used) continue;
    used.insert(difference.point);
    measured += static_cast<int>(setup.control.at(difference.point).sigma_m.array().isFinite().count());
  }
  for (std::size_t i = 0; i < setup.control_observations.size(); ++i) {
    const ControlObservation& seen = setup.control_observations[i];
    if (!used.contains(seen.point) || !adjusted.control_residuals_px[i].allFinite()) continue;
    sum += adjusted.control_residuals_px[i].squaredNorm() / (seen.sigma_px * seen.sigma_px);
    measured += 2;
  }
  const int redundancy = measured - 3 * static_cast<int>(used.size());
  if (used.size() < 3 || redundancy < kLeastRedundancy) return 0;
  return std::max(largest, std::sqrt(sum / redundancy));
}

std::optional<std::pair<ObservationGroup, double>> next_doubt(const Block& setup, const Adjusted& adjusted,
                                                              const SigmaFactors& taken) {
  std::optional<std::pair<ObservationGroup, double>> next;
  double surest = 0;
  for (const auto& [group, shown] : shown_by_coordinates(setup, adjusted)) {
    // never below what was stated: then it is not the coordinates that are wrong
    const double factor = std::clamp(shown.sigma_factor(group), 1 / taken[static_cast<std::size_t>(group)], kStep);
    const double change = std::abs(std::log(factor)), sure = change * std::sqrt(shown.redundancy);
    if (change > std::log(kSettled) && sure > surest) next = {group, factor}, surest = sure;
  }
  return next;
}

Eigen::Vector3d position_shift(const Block& setup, const Adjusted& tied) {
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> positions_m, control_m;
    for (const PositionDifference& position : tied.positions)
      if (std::isfinite(setup.images.at(position.image).position->sigma_m[axis]))
        positions_m.push_back(position.difference_m[axis]);
    for (const ControlDifference& control : tied.control)
      if (control.used && std::isfinite(control.difference_m[axis])) control_m.push_back(control.difference_m[axis]);
    if (positions_m.empty() || control_m.empty()) continue;
    const double middle_m = std::accumulate(control_m.begin(), control_m.end(), 0.0) / control_m.size();
    shift_m[axis] = median(positions_m) - middle_m;
  }
  return shift_m;
}

Block with_positions_shifted(Block setup, const Eigen::Vector3d& shift_m) {
  for (auto& [id, image] : setup.images)
    if (image.position) image.position->position_in_world += shift_m;
  return setup;
}

}  // namespace collinea
