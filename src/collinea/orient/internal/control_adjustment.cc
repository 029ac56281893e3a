// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/control_adjustment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collinea/epipolar/intersect.h"
#include "collinea/orient/internal/control_doubt.h"
#include "collinea/orient/internal/incremental.h"

namespace collinea {
namespace {

constexpr double kControlMisfit = 2.5;  // of control's own sigma0: what no chance explains
constexpr int kControlRounds = 10;

// sigma0 of the image measurements of control alone, by the intersection of each point; 0 with little redundancy.
double measurement_misfit(const Block& block) {
  double squares = 0, redundancy = 0;
  for (const auto& [id, point] : block.control) {
    const std::vector<SightLine> lines = sight_lines(block, id);
    const auto met = intersect(lines);
    if (lines.size() < 2 || !met) continue;
    const double of_point = 2 * static_cast<double>(lines.size()) - 3;
    squares += met->sigma0 * met->sigma0 * of_point;
    redundancy += of_point;
  }
  return redundancy < kLeastRedundancy ? 0 : std::sqrt(squares / redundancy);
}

// Rays to one control point that miss each other by many times their sigma were not measured as well as stated.
void weigh_measurements(Reconstruction& part, ControlAdjustment& result) {
  const double factor = measurement_misfit(part.block());
  if (factor < kControlMisfit) return;
  Block setup = part.setup();
  double sigma_px = 0;
  for (ControlObservation& seen : setup.control_observations) sigma_px = std::max(sigma_px, seen.sigma_px *= factor);
  part.set_setup(std::move(setup));
  result.sigma_factors[std::size_t(ObservationGroup::kControlImages)] = factor;
  result.findings.push_back(finding_of(FindingCode::kControlMeasurementSigma, {},
                                       {{FigureName::kRatio, factor}, {FigureName::kSigmaPx, sigma_px}},
                                       {RemedyCode::kLookForMarks}));
}

Block with_control_sigmas(const Block& setup, ObservationGroup group, double factor) {
  SigmaFactors factors = as_given();
  factors[std::size_t(group)] = factor;
  return with_sigmas(setup, factors);
}

// Shifts the positions to where control puts the block, and answers by how much [m].
Eigen::Vector3d shift_positions(Reconstruction& part, const Adjusted& adjusted) {
  const Eigen::Vector3d shift_m = position_shift(part.setup(), adjusted);
  part.set_setup(with_positions_shifted(part.setup(), shift_m));
  return shift_m;
}

std::vector<Finding> findings_of_shift(const Eigen::Vector3d& shift_m) {
  if (shift_m.isZero()) return {};
  return {finding_of(
      FindingCode::kPositionsShifted, {},
      {{FigureName::kEast, shift_m.x()}, {FigureName::kNorth, shift_m.y()}, {FigureName::kUp, shift_m.z()}})};
}

// Groups of coordinates whose sigmas were multiplied, with the largest sigma now.
std::vector<Finding> findings_of_sigmas(const Block& setup, const SigmaFactors& factors) {
  constexpr ObservationSource kSource = ObservationSource::kControlCoordinates;
  std::vector<Finding> findings;
  for (const ObservationGroup group : groups_of(kSource)) {
    const double factor = factors[std::size_t(group)];
    if (factor == 1) continue;
    double sigma_m = 0;
    for (const auto& [id, point] : setup.control)
      for (int axis = 0; axis < 3; ++axis)
        if (point.role == ControlRole::kControl && group_of(kSource, axis) == group &&
            std::isfinite(point.sigma_m[axis]))
          sigma_m = std::max(sigma_m, point.sigma_m[axis]);
    findings.push_back(finding_of(
        group == ObservationGroup::kControlPlan ? FindingCode::kControlSigmaPlan : FindingCode::kControlSigmaHeight, {},
        {{FigureName::kRatio, factor}, {FigureName::kSigma, sigma_m}}, {RemedyCode::kLookForPoints}));
  }
  return findings;
}

// Coordinates of control that contradict the block, and themselves, by many times their sigma cannot be as good as
// stated: they are given the sigma they show, one group at a time, and adjusted again.
Result<> weigh_coordinates(Reconstruction& part, const AdjustScope& scope, bool shift_is_unknown,
                           const OrientOptions& options, const Run& run, ControlAdjustment& result) {
  Adjusted& adjusted = result.adjusted;
  Eigen::Vector3d shift_m = shift_is_unknown ? Eigen::Vector3d(0, 0, 0) : shift_positions(part, adjusted);
  SigmaFactors factors = as_given();
  for (int round = 0; round < kControlRounds; ++round) {
    const auto doubt = next_doubt(part.setup(), adjusted, factors);
    if (!doubt) break;
    const auto [group, factor] = *doubt;
    factors[std::size_t(group)] *= factor;
    part.set_setup(with_control_sigmas(part.setup(), group, factor));
    COLLINEA_TRY(adjusted, examine_settled(part, scope, options, run));
    if (!shift_is_unknown) shift_m += shift_positions(part, adjusted);
  }
  result.position_shift_m = shift_m;
  for (const ObservationGroup group : groups_of(ObservationSource::kControlCoordinates))
    result.sigma_factors[std::size_t(group)] = factors[std::size_t(group)];
  for (auto&& findings : {findings_of_shift(shift_m), findings_of_sigmas(part.setup(), factors)})
    result.findings.insert(result.findings.end(), findings.begin(), findings.end());
  return {};
}

}  // namespace

Result<Adjusted> adjust_settled(Reconstruction& part, const AdjustScope& scope, const OrientOptions& options,
                                const Run& run) {
  AdjustOptions adjust = settled_options(part, options);
  adjust.first_damping = kSettledDamping;
  return part.adjust_all(adjust, scope, run);
}

Result<Adjusted> examine_settled(Reconstruction& part, const AdjustScope& scope, const OrientOptions& options,
                                 const Run& run) {
  AdjustOptions adjust = settled_options(part, options);
  adjust.first_damping = kSettledDamping;
  return part.examine_all(adjust, scope, run);
}

Result<ControlAdjustment> adjust_with_control(Reconstruction& part, const AdjustScope& scope, bool shift_is_unknown,
                                              const OrientOptions& options, const Run& run) {
  ControlAdjustment result;
  if (scope.use_control) weigh_measurements(part, result);
  COLLINEA_TRY(settle(part, scope, options, false, run));
  if (!scope.use_control || part.setup().control.empty()) {
    COLLINEA_TRY(result.adjusted, adjust_settled(part, scope, options, run));
    return result;
  }
  COLLINEA_TRY(result.adjusted, examine_settled(part, scope, options, run));
  if (control_misfit(part.setup(), result.adjusted) < kControlMisfit) return result;
  COLLINEA_TRY(weigh_coordinates(part, scope, shift_is_unknown, options, run, result));
  COLLINEA_TRY(settle(part, scope, options, false, run));
  COLLINEA_TRY(result.adjusted, adjust_settled(part, scope, options, run));
  return result;
}

}  // namespace collinea
