// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/orientation_findings.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/jobs/internal/point_spread.h"
#include "collinea/report/fit_findings.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

constexpr double kInFront = 0.9;       // of the points: a few may be wrong
constexpr int kFewPairPoints = 12;     // two at each of the six positions of von Gruber: they check each other
constexpr int kFewCommonPoints = 4;    // each is a condition on the ratio of the bases: of three two outvote one
constexpr double kFewTimesNoise = 10;  // fourth singular value over the fifth: depth is a tenth noise
constexpr double kPoorFocal = 0.02;    // sigma over principal distance, which scales all depths

std::vector<Subject> points_named(std::span<const std::string> names) {
  std::vector<Subject> out;
  for (const std::string& name : names) out.push_back(Subject::point(name));
  return out;
}

void add_shape(const PairShape& shape, std::vector<Finding>& findings) {
  for (const PairWeakness weakness : shape.weaknesses) {
    if (weakness == PairWeakness::kNearPlane) continue;  // points off the plane tell both orientations apart
    findings.push_back(finding_of(C::kPairGeometry, {}, {{F::kRatio, shape.inflation}}, {RemedyCode::kLeaveSurface},
                                  std::string(word_of(weakness))));
  }
}

std::vector<MeasurementTest> tests_of(const FactorisationReport& report,
                                      const FactorisationReport::Euclidean& euclidean) {
  std::vector<MeasurementTest> tests;
  for (std::size_t k = 0; k < euclidean.marks.size(); ++k)
    tests.push_back({report.points[k / report.images.size()], report.images[k % report.images.size()],
                     euclidean.marks[k].w.cwiseAbs().maxCoeff()});
  return tests;
}

void add_refuted(C code, const VarianceTest& free, const VarianceTest& bound, RemedyCode remedy,
                 std::vector<Finding>& findings) {
  if (const auto test = test_of_conditions(free, bound); test && test->is_refuted())
    findings.push_back(finding_of(code, {}, {{F::kRatio, test->ratio}, {F::kChance, test->chance}}, {remedy}));
}

void add_calibration(const FactorisationReport& report, std::vector<Finding>& findings) {
  if (!report.why_not_euclidean.empty())
    findings.push_back(
        finding_of(C::kNoEuclideanForm, {}, {}, {RemedyCode::kAddImagesFromElsewhere}, report.why_not_euclidean));
  if (!report.why_not_calibrated.empty())
    findings.push_back(
        finding_of(C::kCameraFitsNot, {}, {}, {RemedyCode::kCheckAssignment}, report.why_not_calibrated));
  if (!report.self_calibrated) return;
  add_refuted(C::kOneCalibrationRefuted, report.projective_variance, report.self_calibrated->variance,
              RemedyCode::kLookForPoints, findings);
  if (report.calibrated)
    add_refuted(C::kStatedCameraRefuted, report.self_calibrated->variance, report.calibrated->variance,
                RemedyCode::kCalibrateCamera, findings);
  const Estimate& focal = report.self_calibrated->interior.front();
  if (const double relative = focal.sigma.value_or(0) / focal.value; relative > kPoorFocal)
    findings.push_back(
        finding_of(C::kPrincipalDistanceWeak, {}, {{F::kRelative, relative}}, {RemedyCode::kAddDistances}));
}

void add_control_geometry(const AbsoluteReport& report, const ControlFit& control, std::vector<Finding>& findings) {
  if (report.is_plane ? report.full < 3 : report.full < 4 || report.full + report.height < 5)
    findings.push_back(report.is_plane
                           ? finding_of(C::kFewPoints, {}, {{F::kCount, double(report.full)}, {F::kLimit, 3}},
                                        {RemedyCode::kMeasureMorePoints})
                           : finding_of(C::kControlFew, {},
                                        {{F::kCount, double(report.full)}, {F::kHeights, double(report.height)}},
                                        {RemedyCode::kGiveControlAtEdges}));
  std::vector<Eigen::Vector3d> full;
  for (const AbsoluteControl& pair : control.used_pairs())
    if (pair.is_full()) full.push_back(pair.in_ground);
  if (const double ratio = width_over_length(full); !report.is_plane && full.size() > 2 && ratio < kNearLine)
    findings.push_back(finding_of(C::kControlOnLine, {}, {{F::kCount, double(full.size())}, {F::kRatio, ratio}},
                                  {RemedyCode::kGiveControlOffLine}));
}

Finding points_behind(int count, int of) {
  return finding_of(C::kPointsBehind, {}, {{F::kCount, double(count)}, {F::kOf, double(of)}},
                    {RemedyCode::kCheckAssignment});
}

}  // namespace

void add_choice_findings(const RelativeOrientation& orientation, std::span<const RelativeSolution, 4> solutions,
                         std::vector<Finding>& findings) {
  if (orientation.in_front < kInFront * orientation.used)
    findings.push_back(points_behind(orientation.used - orientation.in_front, orientation.used));
  const auto alike = std::ranges::count(solutions, solutions[0].in_front, &RelativeSolution::in_front);
  if (alike > 1)
    findings.push_back(finding_of(C::kSolutionsOpen, {}, {{F::kCount, double(alike)}}, {RemedyCode::kCheckAssignment}));
}

std::vector<Finding> relative_findings(const RelativeReport& report) {
  const RelativeOrientation& orientation = report.orientation;
  std::vector<Finding> findings;
  std::vector<MeasurementTest> tests;
  std::vector<Subject> rejected;
  const double unit = std::sqrt(orientation.variance_factor);
  for (std::size_t i = 0; i < report.names.size(); ++i) {
    const PairResidual& residual = orientation.residuals[i];
    if (!residual.used) rejected.push_back(Subject::point(report.names[i]));
    if (residual.used && unit > 0) tests.push_back({report.names[i], "", std::abs(residual.standardised) / unit, 1});
  }
  if (orientation.redundancy > 0 && orientation.used < kFewPairPoints)
    findings.push_back(finding_of(C::kFewPoints, {},
                                  {{F::kCount, double(orientation.used)}, {F::kLimit, double(kFewPairPoints)}},
                                  {RemedyCode::kMeasureMorePoints}));
  if (report.shape) add_shape(*report.shape, findings);
  add_choice_findings(orientation, report.solutions, findings);
  add_measurement_findings({orientation.sigma0, static_cast<int>(std::lround(orientation.redundancy)),
                            report.options.sigma_known, report.options.alpha},
                           tests, findings);
  add_rejected_finding(C::kMeasurementsRejected, rejected, report.names.size(), findings);
  return findings;
}

std::vector<Finding> given_relative_findings(const RelativeReport& report) {
  const RelativeOrientation& orientation = report.orientation;
  std::vector<Finding> findings;
  if (orientation.in_front < kInFront * orientation.used)
    findings.push_back(points_behind(orientation.used - orientation.in_front, orientation.used));
  if (!report.options.sigma_known) return findings;
  std::vector<MeasurementTest> tests;
  for (std::size_t i = 0; i < report.names.size(); ++i)
    tests.push_back({report.names[i], "", std::abs(report.coplanarity->points[i].w), 1});
  // Nothing is estimated: each point is a condition that checks the elements.
  add_measurement_findings(
      {report.coplanarity->sigma0, static_cast<int>(report.names.size()), true, report.options.alpha}, tests, findings);
  return findings;
}

std::vector<Finding> triplet_findings(const TripletReport& report) {
  std::vector<Finding> findings;
  const auto& all = report.joined.combinations;
  const auto acceptable = std::ranges::count(all, true, &ThreeImageCombination::is_joined);
  if (acceptable != 2)
    findings.push_back(
        finding_of(C::kCombinationsOpen, {}, {{F::kCount, double(acceptable)}}, {RemedyCode::kMeasureMorePoints}));
  const auto common = static_cast<int>(report.common);
  if (const int in_front = all[static_cast<std::size_t>(report.joined.chosen)].in_front; in_front < common)
    findings.push_back(points_behind(common - in_front, common));
  if (common < kFewCommonPoints)
    findings.push_back(finding_of(C::kFewPoints, {},
                                  {{F::kCount, double(common)}, {F::kLimit, double(kFewCommonPoints)}},
                                  {RemedyCode::kMeasureMorePoints}));
  if (!report.without_position.empty())
    findings.push_back(finding_of(C::kRaysWithoutPoint, points_named(report.without_position),
                                  {{F::kCount, double(report.without_position.size())}},
                                  {RemedyCode::kCheckAssignment}));
  std::vector<MeasurementTest> tests;
  std::set<std::string> rejected, points;
  for (const TripletReport::Mark& mark : report.marks) {
    points.insert(mark.point);
    if (mark.is_rejected)
      rejected.insert(mark.point);
    else
      tests.push_back({mark.point, mark.image, mark.test.w.cwiseAbs().maxCoeff()});
  }
  for (const std::string& name : report.without_position) rejected.erase(name);
  add_measurement_findings(report.variance, tests, findings);
  const std::vector<std::string> names(rejected.begin(), rejected.end());
  add_rejected_finding(C::kMeasurementsRejected, points_named(names), points.size(), findings);
  return findings;
}

std::vector<Finding> absolute_findings(const AbsoluteReport& report, const ControlFit& control) {
  std::vector<Finding> findings;
  add_control_geometry(report, control, findings);
  if (report.solutions > 1)
    findings.push_back(
        finding_of(C::kSolutionsOpen, {}, {{F::kCount, double(report.solutions)}}, {RemedyCode::kGiveHeightMore}));
  std::vector<ControlTest> tests, checks;
  std::vector<Subject> rejected;
  std::size_t used = 0;
  for (const AbsoluteReport::Point& point : report.points) {
    used += !point.is_check;
    if (point.is_rejected) {
      rejected.push_back(Subject::control_named(point.name));
      continue;
    }
    ControlTest test{point.name, point.misfit, point.w};
    if (!point.has_plan) test.misfit_m.head<2>().setZero(), test.w.head<2>().setZero();
    if (!point.has_height || report.is_plane) test.misfit_m.z() = test.w.z() = 0;
    (point.is_check ? checks : tests).push_back(std::move(test));
  }
  add_check_findings(report.variance, checks, findings);
  if (report.variance.redundancy <= 0)
    findings.push_back(finding_of(C::kNothingChecks, {}, {}, {RemedyCode::kMeasureMorePoints}));
  add_fit_findings(report.variance, tests, findings);
  add_rejected_finding(C::kControlRejected, rejected, used, findings);
  return findings;
}

std::vector<Finding> factorisation_findings(const FactorisationReport& report) {
  std::vector<Finding> findings;
  if (const double ratio = report.projective.fourth / report.projective.fifth; ratio < kFewTimesNoise)
    findings.push_back(finding_of(C::kRankNearThree, {}, {{F::kRatio, ratio}}, {RemedyCode::kAddImagesFromElsewhere}));
  const std::size_t all = report.points.size() + report.left_out.size() + report.rejected.size();
  if (!report.left_out.empty())
    findings.push_back(finding_of(C::kNotInAllImages, points_named(report.left_out),
                                  {{F::kCount, double(report.left_out.size())}, {F::kOf, double(all)}}));
  add_calibration(report, findings);
  if (const auto& euclidean = report.self_calibrated ? report.self_calibrated : report.calibrated)
    add_measurement_findings(euclidean->variance, tests_of(report, *euclidean), findings);
  else
    add_measurement_findings(report.projective_variance, {}, findings);
  add_rejected_finding(C::kMeasurementsRejected, points_named(report.rejected), all, findings);
  return findings;
}

}  // namespace collinea
