// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/model_findings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "collinea/jobs/internal/point_spread.h"
#include "collinea/report/fit_findings.h"

namespace collinea {
namespace {

using Eigen::Vector3d;
using C = FindingCode;
using F = FigureName;

// Seven parameters of 3 n coordinates: with five points each coordinate is checked by half on average.
constexpr std::size_t kFewPoints = 5;

void add_left_out(const ModelsReport& report, std::vector<Finding>& findings) {
  for (const LeftOutModel& one : report.block.chain.left_out) {
    const std::vector<Subject> subjects{Subject::model(report.models[one.model].name)};
    const std::vector<Figure> shared{{F::kCount, double(one.shared)}};
    switch (one.reason) {
      case LeftOutReason::kNoPoint:
        findings.push_back(finding_of(C::kModelNoPoint, subjects, {}, {RemedyCode::kShareModelPoints}));
        break;
      case LeftOutReason::kTooFew:
        findings.push_back(finding_of(C::kModelTurns, subjects, shared, {RemedyCode::kShareModelPoints}));
        break;
      case LeftOutReason::kOnLine:
        findings.push_back(finding_of(C::kModelNotFixed, subjects, shared, {RemedyCode::kShareModelPoints}));
        break;
      case LeftOutReason::kNoControl:
        findings.push_back(finding_of(C::kModelNoControl, subjects, {},
                                      {RemedyCode::kShareModelPoints, RemedyCode::kGiveThreeControlPoints}));
        break;
    }
  }
  for (std::size_t i = 0; i < report.pairs.size(); ++i)
    if (!report.pairs[i].failure.empty())
      findings.push_back(finding_of(C::kPairMakesNoModel, {Subject::file(report.pair_names[i])}, {},
                                    {RemedyCode::kMeasureTiePoints}, report.pairs[i].failure));
}

// By which the model hangs: points of other models that are joined, and control that is fully known.
std::vector<Vector3d> ties_of(const ModelsReport& report, std::size_t model,
                              const std::map<std::string, int>& shown_in) {
  std::vector<Vector3d> ties;
  for (const NamedPoint& point : report.models[model].points) {
    const auto shown = shown_in.find(point.name);
    const bool is_control = std::ranges::any_of(report.control, [&](const SurveyedPoint& one) {
      return one.name == point.name && !one.is_check && one.is_full();
    });
    if ((shown != shown_in.end() && shown->second > 1) || is_control) ties.push_back(point.position);
  }
  return ties;
}

void add_weak(const ModelsReport& report, std::vector<Finding>& findings) {
  std::map<std::string, int> shown_in;
  for (std::size_t m = 0; m < report.models.size(); ++m)
    if (report.block.models[m])
      for (const NamedPoint& point : report.models[m].points) ++shown_in[point.name];
  for (std::size_t m = 0; m < report.models.size(); ++m) {
    if (!report.block.models[m]) continue;
    const std::vector<Subject> subjects{Subject::model(report.models[m].name)};
    const std::vector<Vector3d> ties = ties_of(report, m, shown_in);
    const Figure count{F::kCount, double(ties.size())};
    if (ties.size() < kFewPoints)
      findings.push_back(finding_of(C::kModelFewPoints, subjects, {count, {F::kLimit, double(kFewPoints)}},
                                    {RemedyCode::kShareModelPoints}));
    if (const double ratio = width_over_length(ties); ties.size() > 2 && ratio < kNearLine)
      findings.push_back(
          finding_of(C::kModelPointsOnLine, subjects, {count, {F::kRatio, ratio}}, {RemedyCode::kShareModelPoints}));
    if (const double redundancy = report.block.models[m]->redundancy; redundancy < 1)
      findings.push_back(
          finding_of(C::kModelUnchecked, subjects, {{F::kValue, redundancy}}, {RemedyCode::kShareModelPoints}));
  }
}

void add_control(const ModelsReport& report, std::vector<Finding>& findings) {
  const JoinedBlock& block = report.block;
  std::vector<ControlTest> tests, checks;
  for (const JoinedControl& one : block.control) {
    const SurveyedPoint& point = report.control[one.index];
    if (!one.seen) continue;
    ControlTest test{point.name};
    for (int axis = 0; axis < 3; ++axis) {
      if (!point.has(axis)) continue;
      test.misfit_m[axis] = one.difference[axis];
      test.w[axis] =
          point.is_check ? one.difference[axis] / one.sigma[axis] : one.tests[static_cast<std::size_t>(axis)].w;
    }
    (point.is_check ? checks : tests).push_back(std::move(test));
  }
  const VarianceTest variance{block.sigma0, static_cast<int>(block.redundancy()), report.sigmas_known,
                              report.false_alarm};
  add_check_findings(variance, checks, findings);
  std::vector<Finding> fit;
  add_fit_findings(variance, tests, fit);
  // Of models with images in common residuals are smaller as a rule.
  if (!report.pairs.empty()) std::erase_if(fit, [](const Finding& one) { return one.code == C::kResidualsSmall; });
  findings.insert(findings.end(), fit.begin(), fit.end());
}

}  // namespace

std::vector<Finding> model_findings(const ModelsReport& report) {
  std::vector<Finding> findings;
  add_left_out(report, findings);
  add_weak(report, findings);
  add_control(report, findings);
  return findings;
}

}  // namespace collinea
