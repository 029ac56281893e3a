// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/variance_components.h"

#include <algorithm>
#include <cmath>

#include "collinea/block/subject_label.h"

namespace collinea {
namespace {

constexpr int kMostIterations = 20;
constexpr double kSettled = 0.01;                        // far less than a factor is known by
constexpr double kSmallestStep = 0.2, kLargestStep = 5;  // one step does not do more: weights must not collapse

double factor_of(const SigmaFactors& factors, ObservationGroup group) {
  return factors[static_cast<std::size_t>(group)];
}

// Standard deviations of three coordinates, each times the factor of its group.
Eigen::Vector3d multiplied(Eigen::Vector3d sigmas, ObservationSource source, const SigmaFactors& factors) {
  for (int axis = 0; axis < 3; ++axis) sigmas[axis] *= factor_of(factors, group_of(source, axis));
  return sigmas;
}

}  // namespace

SigmaFactors as_given() {
  SigmaFactors factors;
  factors.fill(1);
  return factors;
}

std::map<std::string, double> factors_by_word(const SigmaFactors& factors) {
  std::map<std::string, double> by_word;
  for (const Word<ObservationGroup>& one : kObservationGroupWords)
    if (const double factor = factor_of(factors, one.value); factor != 1) by_word.emplace(one.word, factor);
  return by_word;
}

SigmaFactors factors_of(const std::map<std::string, double>& by_word) {
  SigmaFactors factors = as_given();
  for (const auto& [word, factor] : by_word)
    if (const auto group = from_word<ObservationGroup>(word)) factors[static_cast<std::size_t>(*group)] = factor;
  return factors;
}

Block with_sigmas(const Block& block, const SigmaFactors& factors) {
  Block scaled = block;
  const double of_tie = factor_of(factors, group_of(ObservationSource::kTieImagePoint, 0)),
               of_control = factor_of(factors, group_of(ObservationSource::kControlImagePoint, 0));
  for (Observation& seen : scaled.observations) seen.sigma_px *= of_tie;
  for (ControlObservation& seen : scaled.control_observations) seen.sigma_px *= of_control;
  for (auto& [id, control] : scaled.control) {
    if (control.role != ControlRole::kControl) continue;  // what is only compared tells nothing, and gets no factor
    control.sigma_m = multiplied(control.sigma_m, ObservationSource::kControlCoordinates, factors);
  }
  for (auto& [id, image] : scaled.images) {
    if (!image.position) continue;
    image.position->sigma_m = multiplied(image.position->sigma_m, ObservationSource::kPosition, factors);
  }
  for (GeodeticObservation& measured : scaled.geodetic)
    if (measured.role == ControlRole::kControl) measured.sigma *= factor_of(factors, group_of(measured.kind));
  return scaled;
}

Result<VarianceComponents> estimate_variance_components(const Block& block, const AdjustScope& scope,
                                                        const ExamineOptions& options, const Run& run) {
  ExamineOptions asked = options;
  asked.reliability = true;
  AdjustScope around = with_first_cameras(scope, block.cameras);  // pseudo-observations stay those of the beginning
  VarianceComponents found;
  found.factors = as_given();
  Block scaled = block;
  for (;; ++found.iterations) {
    for (auto& [id, attitude] : around.attitudes)
      attitude.sigma_rad = multiplied(scope.attitudes.at(id).sigma_rad, ObservationSource::kAttitude, found.factors);
    COLLINEA_TRY(found.adjusted, examine(scaled, around, asked, run));
    if (!found.adjusted.reliability)
      return fail(Errc::kIllPosed, "variance components: " + label_of(found.adjusted.undetermined, block));
    double largest = 0;
    SigmaFactors next = found.factors;
    for (std::size_t g = 0; g < kObservationGroups; ++g) {
      const GroupSums& sums = found.adjusted.reliability->groups[g];
      const double step = std::clamp(sums.sigma_factor(), kSmallestStep, kLargestStep);
      largest = std::max(largest, std::abs(std::log(step)));
      next[g] *= step;
      const bool moved = found.factors[g] != 1;  // drowned on the way: what remains is uncertain
      found.sigma[g] =
          sums.is_determined() || (moved && sums.squared_redundancy > 0) ? found.factors[g] * sums.relative_sigma() : 0;
    }
    found.converged = largest < kSettled;
    if (found.converged || found.iterations == kMostIterations) return found;
    found.factors = next;
    scaled = with_sigmas(block, found.factors);
    apply(found.adjusted, scaled);
  }
}

}  // namespace collinea
