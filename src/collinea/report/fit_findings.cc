// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/fit_findings.h"

#include <cmath>

namespace collinea {

void add_fit_findings(const VarianceTest& variance, std::span<const ControlTest> control,
                      std::vector<Finding>& findings) {
  using C = FindingCode;
  using F = FigureName;
  if (variance.redundancy <= 0) return;
  switch (variance.verdict()) {
    case VarianceVerdict::kTooLarge:
      findings.push_back(finding_of(C::kResidualsLarge, {},
                                    {{F::kRatio, variance.sigma0}, {F::kChance, variance.chance_of_more()}},
                                    {RemedyCode::kLookForPoints}));
      break;
    case VarianceVerdict::kTooSmall:
      findings.push_back(finding_of(C::kResidualsSmall, {},
                                    {{F::kRatio, variance.sigma0}, {F::kChance, variance.chance_of_less()}},
                                    {RemedyCode::kStateSigmas}));
      break;
    case VarianceVerdict::kAgrees:
    case VarianceVerdict::kNotTested:
      break;
  }
  const ControlTest* worst = nullptr;
  int at = 0;
  for (const ControlTest& point : control)
    for (int axis = 0; axis < 3; ++axis)
      if (const double w = std::abs(point.w[axis]); w > variance.limit() && (!worst || w > std::abs(worst->w[at]))) {
        worst = &point;
        at = axis;
      }
  if (worst)
    findings.push_back(finding_of(C::kControlContradicts, {Subject::control_named(worst->name)},
                                  {{F::kOffset, std::abs(worst->misfit_m[at])},
                                   {F::kTest, std::abs(worst->w[at])},
                                   {F::kLimit, variance.limit()}},
                                  {RemedyCode::kLookForPoints}));
}

}  // namespace collinea
