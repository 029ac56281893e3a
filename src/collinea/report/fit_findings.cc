// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/fit_findings.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace collinea {

namespace {

using C = FindingCode;
using F = FigureName;

std::size_t tested_coordinates(std::span<const ControlTest> points) {
  std::size_t tests = 0;
  for (const ControlTest& point : points) tests += std::size_t((point.w.array() != 0).count());
  return tests;
}

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
  if (worst == measurements.end()) return;
  std::size_t tests = 0;
  for (const MeasurementTest& measurement : measurements) tests += measurement.coordinates;
  const double limit = variance.limit(tests);
  if (!(worst->w > limit)) return;
  std::vector<Subject> subjects{Subject::point(worst->point)};
  if (!worst->image.empty()) subjects.push_back(Subject::image_named(worst->image));
  findings.push_back(finding_of(C::kMeasurementContradicts, std::move(subjects),
                                {{F::kTest, worst->w}, {F::kLimit, limit}}, {RemedyCode::kMeasureAgain}));
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

void add_check_findings(const VarianceTest& variance, std::span<const ControlTest> checks,
                        std::vector<Finding>& findings) {
  const double limit = variance.limit_of_checks(tested_coordinates(checks));
  for (const ControlTest& point : checks)
    if (point.w.cwiseAbs().maxCoeff() > limit)
      findings.push_back(
          finding_of(C::kCheckPoint, {Subject::control_named(point.name)}, {{F::kOffset, point.misfit_m.norm()}}));
}

void add_fit_findings(const VarianceTest& variance, std::span<const ControlTest> control,
                      std::vector<Finding>& findings) {
  if (variance.redundancy <= 0) return;
  add_variance_finding(variance, findings);
  const double limit = variance.limit(tested_coordinates(control));
  const ControlTest* worst = nullptr;
  int at = 0;
  for (const ControlTest& point : control)
    for (int axis = 0; axis < 3; ++axis)
      if (const double w = std::abs(point.w[axis]); w > limit && (!worst || w > std::abs(worst->w[at]))) {
        worst = &point;
        at = axis;
      }
  if (!worst) return;
  Subject subject = Subject::control_named(worst->name);
  subject.aspect = Aspect::kPosition;
  subject.axis = static_cast<std::uint8_t>(at);
  findings.push_back(
      finding_of(C::kControlContradicts, {std::move(subject)},
                 {{F::kOffset, std::abs(worst->misfit_m[at])}, {F::kTest, std::abs(worst->w[at])}, {F::kLimit, limit}},
                 {RemedyCode::kLookForPoints}));
}

}  // namespace collinea
