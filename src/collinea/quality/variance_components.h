// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <string>

#include "collinea/quality/examine.h"

namespace collinea {

/// By what the given sigmas of each group of observations are to be multiplied.
using SigmaFactors = std::array<double, kObservationGroups>;

[[nodiscard]] SigmaFactors as_given();  ///< all 1

/// Factors by the words of their groups, those that are 1 left out; and back. Words that name no group are passed over.
[[nodiscard]] std::map<std::string, double> factors_by_word(const SigmaFactors& factors);
[[nodiscard]] SigmaFactors factors_of(const std::map<std::string, double>& by_word);

/// The outcome of estimating variance components.
struct VarianceComponents {
  /// 1 for groups of which too little is known. One that became so on the way (its errors are drowned in those of what
  /// checks it) keeps the factor it had then, an upper bound; its standard deviation is then 40 % and more.
  SigmaFactors factors;
  SigmaFactors sigma;  ///< standard deviation of each factor, from its redundancy numbers; 0 where not estimated
  int iterations = 0;
  bool converged = false;
  Examined adjusted;  ///< with the factors, with reliability
};

/// The block with the sigmas of each group multiplied.
[[nodiscard]] Block with_sigmas(const Block& block, const SigmaFactors& factors);

/// Variance components (Helmert 1907 in the simplified form of Foerstner 1979): adjust, take each group's factor from
/// its squares over its redundancy, adjust again, until no factor changes by more than 1 % (at most 20 times). Control
/// in images and tie points in images count separately. Errors: those of adjust(); kIllPosed when something is not
/// determined.
[[nodiscard]] Result<VarianceComponents> estimate_variance_components(const Block& block, const AdjustScope& scope,
                                                                      const ExamineOptions& options, const Run& run);

}  // namespace collinea
