// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/residual_words.h"

#include <fmt/format.h>

#include <array>
#include <limits>

#include "collinea/block/subject_label.h"

namespace collinea {
namespace {

using F = FigureName;

// Where: "of strip 2", "in images of FC6310", or nothing.
std::string owner_of(const Subject& subject, const Block& block) {
  if (subject.kind == SubjectKind::kStrip) return fmt::format(" along strip {}", subject.id + 1);
  return subject.kind == SubjectKind::kCamera ? " in images of " + name_in_block(subject, block) : "";
}

const char* axis_of(const Subject& subject) {
  constexpr std::array kAxes = {"east", "north", "up"};
  return subject.axis < 3 ? kAxes[subject.axis] : "";
}

const char* image_axis_of(const Subject& subject) { return subject.axis == 0 ? "columns" : "rows"; }

}  // namespace

std::string residual_axis_word(ResidualSeries series, int axis) {
  if (series == ResidualSeries::kPositions) return axis == 0 ? "east" : axis == 1 ? "north" : "up";
  return axis == 0 ? "columns" : "rows";
}

std::string residual_series_words(ResidualSeries series, int axis) {
  const std::string along = ", " + residual_axis_word(series, axis);
  switch (series) {
    case ResidualSeries::kPositions:
      return "positions" + along;
    case ResidualSeries::kImageMeans:
      return "means of images" + along;
    case ResidualSeries::kInImages:
      return "neighbours in images" + along;
    case ResidualSeries::kTiePoints:
      return "tie points" + along;
  }
  return "";
}

std::string residual_words(const Finding& finding, const Block& block) {
  const Subject subject = finding.subjects.empty() ? Subject() : finding.subjects[0];
  const auto figure = [&](F name) { return finding.figure(name).value_or(std::numeric_limits<double>::quiet_NaN()); };
  const double correlation = figure(F::kCorrelation);
  const std::string chance = fmt::format(
      "by accident they are so with a chance of {:.1g}, corrected for the number "
      "of tests",
      figure(F::kChance));
  if (finding.code == FindingCode::kPositionsInOrder)
    return fmt::format(
        "Residuals of positions ({}){} {} in the order flown: correlation {:+.2f} of neighbours, their size {:.3f} m; "
        "{}. Their errors are not those of single images.",
        axis_of(subject), owner_of(subject, block), correlation < 0 ? "take turns" : "follow each other", correlation,
        figure(F::kSigma), chance);
  if (finding.code == FindingCode::kImageResidualsAlike)
    return fmt::format(
        "Residuals of {} that are neighbours{} are alike: correlation {:+.2f}, their size {:.2f} px; {}. What the "
        "model "
        "leaves over is shared by neighbours, and standard deviations are too small where many rays count as "
        "independent.",
        image_axis_of(subject), subject.kind == SubjectKind::kCamera ? owner_of(subject, block) : " in the order flown",
        correlation, figure(F::kSigmaPx), chance);
  const bool of_positions = finding.figure(F::kSigma).has_value() && subject.aspect == Aspect::kPosition;
  return fmt::format(
      "The distribution of residuals of {} ({}) differs by up to {:.1f} % from that by which they are tested; {}. "
      "Suspects may be too many or too few.",
      of_positions ? "positions" : "tie points", of_positions ? axis_of(subject) : image_axis_of(subject),
      100 * figure(F::kShare), chance);
}

}  // namespace collinea
