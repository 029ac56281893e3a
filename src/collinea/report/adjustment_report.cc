// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/adjustment_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/block/geodetic_words.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/internal/cells.h"

namespace collinea {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

void add_rejected(const Snooped& snooped, std::vector<std::string>& notes) {
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, snooped.rejected.size()); ++i)
    notes.push_back("rejected: " + words_of_rejected(snooped.rejected[i], snooped.block));
  if (snooped.rejected.size() > kShown)
    notes.push_back(fmt::format("{} observations rejected in all; rejected.csv lists them", snooped.rejected.size()));
  for (std::size_t i = 0; i < std::min(kShown, snooped.kept.size()); ++i)
    notes.push_back(fmt::format("{} is suspect but stays: {}", name_of(snooped.kept[i].observation, snooped.block),
                                words_of(snooped.kept[i].reason)));
  if (!snooped.finished) notes.emplace_back("more is suspect; as many as were allowed have gone (snoop_most)");
}

}  // namespace

std::vector<std::string> notes_of(const AdjustmentReport& report) {
  std::vector<std::string> notes;
  if (const auto& done = report.refracted)
    notes.push_back(
        fmt::format("refraction: {} measurements corrected by up to {:.3f} px{}", done->corrected, done->largest_px,
                    done->left == 0 ? "" : fmt::format("; {} left, more than 75 degrees from the nadir", done->left)));
  if (const auto& frame = report.block.georeference;
      frame && (frame->deflection_north_rad != 0 || frame->deflection_east_rad != 0)) {
    constexpr double kArcseconds = 180 * 3600 / std::numbers::pi;
    notes.push_back(fmt::format("deflection of the vertical: {:.2f}\" to the north, {:.2f}\" to the east",
                                kArcseconds * frame->deflection_north_rad, kArcseconds * frame->deflection_east_rad));
  }
  if (const auto& found = report.mismatches; found && found->size() > 0)
    notes.push_back(fmt::format("{} of {} measurements of tie points are mismatches and rejected, {} others with them",
                                found->wrong.size(), found->tested, found->with_them.size()));
  if (const auto& weights = report.tie_weights)
    notes.push_back(
        std::isinf(weights->degrees_of_freedom)
            ? "tie points weigh alike: their errors are normal, or too few"
            : fmt::format("tie points weigh by their errors (Student's distribution, {:.1f} degrees of freedom, scale "
                          "{:.2f} of the standard deviations before): a quarter of them {:.2f} and less{}",
                          weights->degrees_of_freedom, weights->scale, weights->lower_quartile,
                          weights->converged ? "" : "; the weights have not settled"));
  if (!report.datum_points.empty() && report.adjusted.rank_defect == 0)
    notes.push_back("datum points " + datum_points_words(report));
  if (report.snooped) add_rejected(*report.snooped, notes);
  if (report.components && !report.components->converged)
    notes.emplace_back("the variance components have not settled; the last ones are used");
  for (const Finding& weak : report.adjusted.weaknesses)
    notes.push_back(sentence_of(weak, report.block, report.spelling));
  return notes;
}

std::vector<std::string> datum_point_names(const AdjustmentReport& report) {
  std::vector<std::string> names;
  for (const ControlId id : report.datum_points.control) names.push_back(report.block.control.at(id).name);
  for (const PointId id : report.datum_points.ties) names.push_back("tie point " + std::to_string(id.value));
  return names;
}

std::string datum_points_words(const AdjustmentReport& report) {
  if (report.datum_points.empty()) return "";
  constexpr std::size_t kShown = 20;
  const std::vector<std::string> names = datum_point_names(report);
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > kShown) text += fmt::format(" and {} more", names.size() - kShown);
  if (report.adjusted.rank_defect == 0)
    return text + ": without effect, because what is given fixes position, attitude and scale already";
  return text + ": standard deviations refer to these, as if they were right in the mean";
}

double shown_factor(const GroupSums& sums) {
  const double factor = sums.sigma_factor();
  return sums.is_determined() || factor > 1 ? factor : std::nan("");
}

const char* unit_of(UnknownKind kind) {
  if (kind == UnknownKind::kDrift) return "m/s";
  if (kind == UnknownKind::kTimeOffset) return "s";
  return kind == UnknownKind::kOrientation || kind == UnknownKind::kBoresight ? "deg" : "m";
}

double in_unit(UnknownKind kind, double value) {
  return std::string_view(unit_of(kind)) == "deg" ? kDegrees * value : value;
}

std::vector<EstimatedUnknown> shown_unknowns(const Adjusted& adjusted) {
  std::vector<EstimatedUnknown> shown;
  for (const EstimatedUnknown& one : adjusted.auxiliaries)
    if (!is_of_shape(one.kind)) shown.push_back(one);
  return shown;
}

TestedObservation in_unit(TestedObservation one) {
  if (!is_angle(one.group)) return one;
  for (double* value : {&one.residual, &one.sigma, &one.gross_error, &one.minimal_detectable_bias, &one.effect})
    *value *= kDegrees;
  return one;
}

const char* unit_of(const TestedObservation& one) {
  if (is_angle(one.group)) return "deg";
  return is_image_point(one.group) ? "px" : "m";
}

std::string name_of(const TestedObservation& one, const Block& block) {
  constexpr const char* kInImage[] = {"column", "row"};
  constexpr const char* kOnGround[] = {"east", "north", "height"};
  switch (one.group) {
    case ObservationGroup::kTieImages: {
      const Observation& seen = block.observations[one.source];
      return fmt::format("tie point {} in {}, {}", seen.point.value, block.images.at(seen.image).file,
                         kInImage[one.axis]);
    }
    case ObservationGroup::kControlImages: {
      const ControlObservation& seen = block.control_observations[one.source];
      return fmt::format("{} in {}, {}", block.control.at(seen.point).name, block.images.at(seen.image).file,
                         kInImage[one.axis]);
    }
    case ObservationGroup::kControlPlan:
    case ObservationGroup::kControlHeight:
      return fmt::format("{}, {}", block.control.at(ControlId{one.source}).name, kOnGround[one.axis]);
    case ObservationGroup::kPositionPlan:
    case ObservationGroup::kPositionHeight:
      return fmt::format("position of {}, {}", block.images.at(ImageId{one.source}).file, kOnGround[one.axis]);
    case ObservationGroup::kAttitudeLevel:
    case ObservationGroup::kAttitudeHeading:
      return fmt::format("attitude of {}, about {}", block.images.at(ImageId{one.source}).file,
                         one.axis == 0   ? "east"
                         : one.axis == 1 ? "north"
                                         : "the plumb line");
    default:  // geodetic observations
      return words_of(block.geodetic[one.source], block);
  }
}

}  // namespace collinea
