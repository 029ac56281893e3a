// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/summary.h"

#include <fmt/format.h>

#include <algorithm>

#include <cmath>

#include "collinea/report/finding_words.h"
#include "collinea/report/internal/counted.h"

namespace collinea {
namespace {

constexpr int kOverlapCells = 110;

std::string axes_text(const AxisRms& rms, const std::string& unit) {
  constexpr std::array<const char*, 3> kNames = {"east", "north", "height"};
  std::string text;
  for (std::size_t i = 0; i < 3; ++i)
    if (rms.axis_m[i]) text += (text.empty() ? "" : ", ") + length_text(rms.axis_m[i], unit) + " in " + kNames[i];
  return text;
}

std::string points(int count, const char* kind) { return counted(count, std::string(kind) + " point"); }

std::string statement_of(const ReportInput& input, const ReportSummary& s) {
  if (s.check.points > 0)
    return fmt::format(
        "Compared with {}, which the adjustment did not use, coordinates differ by {} (root mean square).",
        points(s.check.points, "independent check"), axes_text(s.check, s.unit));
  if (s.control.points > 0)
    return fmt::format(
        "There is no check point, so nothing independent verifies the accuracy. At the {} that the adjustment used, "
        "coordinates differ by {} (root mean square). It was fitted to these: new points are less accurate.",
        points(s.control.points, "control"), axes_text(s.control, s.unit));
  if (input.georeferenced && s.position.points > 0)
    return fmt::format(
        "Position and scale come from the satellite positions of the cameras alone, from which the adjusted ones "
        "differ "
        "by {} (root mean square of {}). An error common to all positions stays unseen: there is no check point.",
        axes_text(s.position, s.unit), counted(s.position.points, "image"));
  if (input.metric && !input.georeferenced)
    return fmt::format(
        "The block has no location on Earth; its scale comes from {} on the ground. Nothing independent "
        "verifies the accuracy: measure a distance that is only compared (role check).",
        counted(std::count_if(input.geodetic.begin(), input.geodetic.end(),
                              [](const GeodeticDifference& one) { return one.used; }),
                "measurement"));
  if (!input.georeferenced)
    return "The block has neither location nor scale on Earth: lengths are in units of the model. Add control points, "
           "image positions or at least a distance to make it a survey.";
  return "Nothing independent verifies the accuracy: there is neither a check point nor a control point.";
}

void add_cautions(const ReportInput& input, ReportSummary& s) {
  const int n = s.check.points;
  if (n > 0 && n < 20)  // the relative error of a root mean square of n normal values is 1 / sqrt(2 n)
    s.cautions.push_back(
        fmt::format("Root mean squares of {} check point{} are themselves uncertain by about {:.0f} %.", n,
                    n == 1 ? "" : "s", 100 / std::sqrt(2.0 * n)));
  if (s.excluded_points > 0)
    s.cautions.push_back(points(s.excluded_points, "control") + (s.excluded_points == 1 ? " was" : " were") +
                         " found wrong and not used: see the table of control.");
  if (!s.not_oriented.empty())
    s.cautions.push_back(fmt::format("{} of {} images could not be oriented: see the list of images left out.",
                                     s.not_oriented.size(), input.block.images.size()));
  for (const Finding& finding : input.findings)
    if (finding.code == FindingCode::kGrossErrorRejected || finding.code == FindingCode::kSystematicTakenUp ||
        (finding.code == FindingCode::kSystematic && finding.severity != Severity::kNote))
      s.cautions.push_back(sentence_of(finding, input.block));
  int beyond = 0;
  for (const ControlDifference& control : input.control)
    for (int i = 0; i < 3 && !control.excluded; ++i)
      beyond += std::abs(control.difference_m[i]) > 3 * control.difference_sigma_m[i];
  if (beyond > 0)
    s.cautions.push_back(
        fmt::format("{} difference{} at control or check points exceed{} three times the predicted standard deviation.",
                    beyond, beyond == 1 ? "" : "s", beyond == 1 ? "s" : ""));
}

// Left out already because it could not be read: it is reported with that reason.
bool skipped(const ReportInput& input, const std::string& file) {
  return std::any_of(input.skipped.begin(), input.skipped.end(), [&](const Finding& one) {
    const Subject& subject = one.subjects.at(0);
    return file == (subject.image() ? input.block.images.at(*subject.image()).file : subject.name);
  });
}

}  // namespace

std::string length_text(std::optional<double> length, const std::string& unit) {
  if (!length || !std::isfinite(*length)) return "\xe2\x80\x93";
  const double size = std::abs(*length);
  const int decimals = size > 0 ? std::clamp(1 - int(std::floor(std::log10(size))), 3, 8) : 3;
  return fmt::format("{:.{}f} {}", *length, decimals, unit);
}

ReportSummary summary_of(const ReportInput& input) {
  ReportSummary s;
  s.unit = input.metric ? "m" : "units";
  s.residuals = residual_statistics(input.block);
  s.coverage = coverage_of(input.block);
  s.overlap = overlap_of(s.coverage, kOverlapCells);
  s.check = control_rms(input, false);
  s.control = control_rms(input, true);
  s.position = position_rms(input);
  for (const ControlDifference& control : input.control) {
    if (control.rays == 0 && !control.excluded) continue;
    ++(control.excluded ? s.excluded_points : control.used ? s.control_points : s.check_points);
  }
  for (const auto& [id, image] : input.block.images)
    if (!is_oriented(input.block, id) && !skipped(input, image.file)) s.not_oriented.push_back(id);
  s.statement = statement_of(input, s);
  add_cautions(input, s);
  return s;
}

}  // namespace collinea
