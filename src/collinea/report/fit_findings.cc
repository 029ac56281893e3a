// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/fit_findings.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace collinea {

namespace {

using C = FindingCode;
using F = FigureName;

}  // namespace

void add_variance_finding(const VarianceTest& variance, std::vector<Finding>& findings, std::vector<Subject> of) {
  switch (variance.verdict()) {
    case VarianceVerdict::kTooLarge:
      findings.push_back(finding_of(C::kResidualsLarge, std::move(of),
                                    {{F::kRatio, variance.sigma0}, {F::kChance, variance.chance_of_more()}},
                                    {RemedyCode::kLookForPoints}));
      break;
    case VarianceVerdict::kTooSmall:
      findings.push_back(finding_of(C::kResidualsSmall, std::move(of),
                                    {{F::kRatio, variance.sigma0}, {F::kChance, variance.chance_of_less()}},
                                    {RemedyCode::kStateSigmas}));
      break;
    case VarianceVerdict::kAgrees:
    case VarianceVerdict::kNotTested:
      break;
  }
}

void add_measurement_findings(const VarianceTest& variance, std::span<const MeasurementTest> measurements,
                              std::vector<Finding>& findings) {
  if (variance.redundancy <= 0) {
    findings.push_back(finding_of(C::kNothingChecks, {}, {}, {RemedyCode::kMeasureMorePoints}));
    return;
  }
  add_variance_finding(variance, findings);
  const auto worst = std::ranges::max_element(measurements, {}, &MeasurementTest::w);
  if (worst == measurements.end() || !(worst->w > variance.limit())) return;
  std::vector<Subject> subjects{Subject::point(worst->point)};
  if (!worst->image.empty()) subjects.push_back(Subject::image_named(worst->image));
  findings.push_back(finding_of(C::kMeasurementContradicts, std::move(subjects),
                                {{F::kTest, worst->w}, {F::kLimit, variance.limit()}}, {RemedyCode::kMeasureAgain}));
}

void add_rejected_finding(FindingCode code, std::span<const Subject> rejected, std::size_t of,
                          std::vector<Finding>& findings) {
  constexpr double kMany = 0.2;  // more is no accident: sigmas, names or the geometry are wrong
  if (rejected.empty()) return;
  const auto count = double(rejected.size());
  Finding finding = finding_of(code, {rejected.begin(), rejected.end()}, {{F::kCount, count}, {F::kOf, double(of)}});
  if (count > kMany * double(of)) {
    finding.severity = Severity::kWeak;
    finding.remedies = {RemedyCode::kLookForPoints};
  }
  findings.push_back(std::move(finding));
}

void add_fit_findings(const VarianceTest& variance, std::span<const ControlTest> control,
                      std::vector<Finding>& findings) {
  if (variance.redundancy <= 0) return;
  add_variance_finding(variance, findings);
  const ControlTest* worst = nullptr;
  int at = 0;
  for (const ControlTest& point : control)
    for (int axis = 0; axis < 3; ++axis)
      if (const double w = std::abs(point.w[axis]); w > variance.limit() && (!worst || w > std::abs(worst->w[at]))) {
        worst = &point;
        at = axis;
      }
  if (!worst) return;
  Subject subject = Subject::control_named(worst->name);
  subject.aspect = Aspect::kPosition;
  subject.axis = static_cast<std::uint8_t>(at);
  findings.push_back(finding_of(
      C::kControlContradicts, {std::move(subject)},
      {{F::kOffset, std::abs(worst->misfit_m[at])}, {F::kTest, std::abs(worst->w[at])}, {F::kLimit, variance.limit()}},
      {RemedyCode::kLookForPoints}));
}

}  // namespace collinea
