// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/image_findings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/report/fit_findings.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kWeakRatio = 1e-5;  // of eigenvalues: below it a pose of vertical photographs is unusually weak
constexpr double kOnCircle = 0.05;   // RMS of points off the circle over its radius
constexpr double kNearCircle = 0.1;  // of the station off the circle, over the radius
// Rays from positions apart by a tenth of the distance: depth is known ten times worse than the position across.
const double kNarrow_rad = std::atan(0.1);

Subject subject_of(const ResectionReport& report, const ResectionReport::Image& image) {
  return report.is_station() ? Subject::point(image.name) : Subject::image_named(image.name);
}

void add_pose(const ResectionReport& report, const ResectionReport::Image& image, const ResectOneOptions& options,
              std::vector<Finding>& findings) {
  const std::vector<Subject> subjects{subject_of(report, image)};
  if (const auto count = double(image.solutions.size()); count > 1) {
    const bool is_decided = report.variance.redundancy > 0 || options.near;
    findings.push_back(is_decided ? finding_of(C::kSolutionChosen, subjects, {{F::kCount, count}})
                                  : finding_of(C::kSolutionsOpen, subjects, {{F::kCount, count}},
                                               {RemedyCode::kGiveFourthPoint, "near"_option}));
  }
  if (!image.is_determined)
    findings.push_back(finding_of(C::kPoseOpen, subjects, {}, {RemedyCode::kGivePrincipalDistance}));
  if (image.conditioning && image.conditioning->ratio < kWeakRatio)
    findings.push_back(
        finding_of(C::kPoseWeak, subjects, {{F::kRatio, image.conditioning->ratio}}, {RemedyCode::kSpreadControl}));
}

// Where the station is open every position on the arc is on the circle.
void add_danger(const ResectionReport& report, const ResectionReport::Image& image, std::vector<Finding>& findings) {
  if (!image.danger) return;
  const DangerCylinder& danger = *image.danger;
  if (!(danger.points_off_m < kOnCircle * danger.radius_m) ||
      !(std::abs(danger.centre_off_m) < kNearCircle * danger.radius_m))
    return;
  findings.push_back(finding_of(C::kDangerCircle, {subject_of(report, image)},
                                {{F::kRadius, danger.radius_m}, {F::kOffset, std::abs(danger.centre_off_m)}},
                                {RemedyCode::kLeaveCircle}));
}

void add_unseen(const IntersectionReport& report, std::vector<Finding>& findings) {
  std::vector<Subject> once, none;
  for (const IntersectionReport::Point& point : report.points)
    if (!point.is_found) (point.rays_given < 2 ? once : none).push_back(Subject::point(point.name));
  if (!once.empty()) {
    const Figure count{F::kCount, double(once.size())};
    Finding finding = finding_of(C::kSeenOnce, once, {count}, {RemedyCode::kMeasureInMoreImages});
    if (once.size() == report.points.size()) finding.severity = Severity::kWrong;  // one image, or names that differ
    findings.push_back(std::move(finding));
  }
  if (!none.empty())
    findings.push_back(
        finding_of(C::kRaysWithoutPoint, none, {{F::kCount, double(none.size())}}, {RemedyCode::kCheckAssignment}));
}

void add_narrow(const IntersectionReport& report, std::vector<Finding>& findings) {
  std::vector<Subject> narrow;
  double least = kNarrow_rad;
  for (const IntersectionReport::Point& point : report.points)
    if (point.is_found && point.max_angle_rad < kNarrow_rad) {
      narrow.push_back(Subject::point(point.name));
      least = std::min(least, point.max_angle_rad);
    }
  if (narrow.empty()) return;
  const std::vector<Figure> figures{
      {F::kCount, double(narrow.size())}, {F::kAngle, kDegrees * least}, {F::kLimit, kDegrees * kNarrow_rad}};
  findings.push_back(finding_of(C::kRaysNarrow, std::move(narrow), figures, {RemedyCode::kTakeWiderBase}));
}

// Of three rays and more the one that misses is named; points are independent of each other.
void add_missing(const IntersectionReport& report, std::vector<Finding>& findings) {
  std::size_t tests = 0;
  for (const IntersectionReport::Point& point : report.points) tests += 2 * point.rays.size();
  const double limit = report.variance.limit(tests);
  std::vector<Subject> of_two;
  double largest = 0;
  for (const IntersectionReport::Point& point : report.points) {
    const auto test = [](const IntersectionReport::Ray& ray) { return ray.w.cwiseAbs().maxCoeff(); };
    const auto worst = std::ranges::max_element(point.rays, {}, test);
    if (worst == point.rays.end() || !(test(*worst) > limit)) continue;
    if (point.rays.size() > 2) {
      findings.push_back(finding_of(C::kMeasurementContradicts,
                                    {Subject::point(point.name), Subject::image_named(worst->image)},
                                    {{F::kTest, test(*worst)}, {F::kLimit, limit}}, {RemedyCode::kMeasureAgain}));
      continue;
    }
    of_two.push_back(Subject::point(point.name));
    largest = std::max(largest, test(*worst));
  }
  if (of_two.empty()) return;
  const Figure count{F::kCount, double(of_two.size())};
  findings.push_back(finding_of(C::kRaysMiss, std::move(of_two), {count, {F::kTest, largest}, {F::kLimit, limit}},
                                {RemedyCode::kMeasureInMoreImages}));
}

// The image, where it has a name, and marks of it.
std::vector<Subject> of_image(const InteriorReport::Image& image, const std::vector<std::string>& marks = {}) {
  std::vector<Subject> subjects{Subject::image_named(image.name)};
  for (const std::string& mark : marks) subjects.push_back(Subject::mark(mark));
  return subjects;
}

void add_readings(const InteriorReport::Image& image, std::vector<Finding>& findings) {
  std::vector<std::string> contested, gross;
  std::size_t readings = 0;
  for (const ReadMark& mark : image.readings.marks) {
    if (mark.is_contested) contested.push_back(mark.mark);
    if (!mark.gross.empty()) gross.push_back(mark.mark);
    readings += mark.gross.size();
  }
  if (!contested.empty())
    findings.push_back(finding_of(C::kReadingsContested, of_image(image, contested),
                                  {{F::kCount, double(contested.size())}}, {RemedyCode::kReadMarksAgain}));
  if (!gross.empty())
    findings.push_back(finding_of(C::kReadingsGross, of_image(image, gross), {{F::kCount, double(readings)}}));
}

void add_names(const InteriorReport& report, const InteriorReport::Image& image, std::vector<Finding>& findings) {
  if (!image.unknown.empty())
    findings.push_back(finding_of(C::kFiducialsUnknown, of_image(image, image.unknown),
                                  {{F::kCount, double(image.unknown.size())}}, {RemedyCode::kCompareMarkNames}));
  if (image.missing.empty()) return;
  Finding missing =
      finding_of(C::kFiducialsMissing, of_image(image, image.missing),
                 {{F::kCount, double(image.missing.size())}, {F::kOf, double(report.calibration.marks.size())}});
  // Of marks found in a scan so few may be something else.
  if (image.least_correlation && image.readings.marks.size() <= image.missing.size()) {
    missing.severity = Severity::kWeak;
    missing.remedies = {RemedyCode::kCompareMarkNames};
  }
  findings.push_back(std::move(missing));
}

void add_fit(const InteriorReport& report, const InteriorReport::Image& image, std::vector<Finding>& findings) {
  const FilmFit& fit = image.orientation.fit;
  std::vector<std::string> misread;
  for (const FilmMarkResidual& mark : fit.marks)
    if (!mark.is_used) misread.push_back(mark.name);
  if (!misread.empty())
    findings.push_back(finding_of(C::kFiducialsLeftOut, of_image(image, misread),
                                  {{F::kCount, double(misread.size())}, {F::kOf, double(fit.marks.size())}},
                                  {RemedyCode::kCompareMarkNames}));
  const std::vector<Subject> by_name = image.name.empty() ? std::vector<Subject>{} : of_image(image);
  if (fit.redundancy <= 0)
    findings.push_back(finding_of(C::kNothingChecks, by_name));
  else if (contradicts_itself(report, image))
    findings.push_back(finding_of(
        C::kFiducialsContradict, of_image(image),
        {report.sigmas_are_known
             ? Figure{F::kRatio, fit.sigma0}
             : Figure{F::kOffset,
                      1e-3 * fit.sigma0 / std::sqrt(std::abs(fit.transformation.by_film({0, 0}).determinant()))}},
        {RemedyCode::kCompareMarkNames}));
  else
    add_variance_finding({fit.sigma0, fit.redundancy, report.sigmas_are_known}, findings, by_name);
  if (fit.transformation.is_mirrored) findings.push_back(finding_of(C::kSeenFromBehind, of_image(image)));
}

}  // namespace

std::vector<Finding> resection_findings(const ResectionReport& report, const ResectOneOptions& options) {
  std::vector<Finding> findings;
  std::vector<MeasurementTest> tests;
  std::vector<Subject> rejected;
  for (const ResectionReport::Mark& mark : report.marks)
    if (mark.is_rejected)
      rejected.push_back(Subject::point(mark.point));
    else
      tests.push_back({mark.point, report.is_station() ? "" : mark.image, mark.w.cwiseAbs().maxCoeff(),
                       report.is_station() ? std::size_t(1) : 2});
  for (const ResectionReport::Image& image : report.images) {
    add_pose(report, image, options, findings);
    add_danger(report, image, findings);
  }
  add_measurement_findings(report.variance, tests, findings);
  add_rejected_finding(C::kMeasurementsRejected, rejected, report.marks.size(), findings);
  return findings;
}

std::vector<Finding> danger_findings(const ResectionReport& report) {
  std::vector<Finding> findings;
  for (const ResectionReport::Image& image : report.images) add_danger(report, image, findings);
  return findings;
}

std::vector<Finding> intersection_findings(const IntersectionReport& report) {
  std::vector<Finding> findings;
  add_unseen(report, findings);
  add_narrow(report, findings);
  add_missing(report, findings);
  if (report.variance.redundancy > 0) add_variance_finding(report.variance, findings);
  if (!report.orientations_have_sigmas)
    findings.push_back(finding_of(C::kOrientationsExact, {}, {}, {RemedyCode::kStateOrientationSigmas}));
  return findings;
}

std::vector<Finding> interior_findings(const InteriorReport& report) {
  std::vector<Finding> findings;
  for (const InteriorReport::Image& image : report.images) {
    if (!image.has_marks) continue;
    add_readings(image, findings);
    add_names(report, image, findings);
    add_fit(report, image, findings);
  }
  return findings;
}

}  // namespace collinea
