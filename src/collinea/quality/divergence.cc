// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/divergence.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "collinea/block/subject_label.h"

namespace collinea {
namespace {

constexpr double kMostLost = 0.05;  // of the image points, where nothing is found that is grossly wrong
constexpr std::size_t kShown = 5;

std::string label_of(const Measurement& one, const Block& block) {
  switch (traits_of(one.group).source) {
    case ObservationSource::kTieImagePoint:
      return "tie point " + std::to_string(one.point.value) + " in " + block.images.at(one.image).file;
    case ObservationSource::kControlImagePoint:
      return block.control.at(one.control).name + " in " + block.images.at(one.image).file;
    case ObservationSource::kControlCoordinates:
      return block.control.at(one.control).name;
    case ObservationSource::kPosition:
    case ObservationSource::kAttitude:
      return block.images.at(one.image).file;
    case ObservationSource::kGeodetic:
      return label_of(Subject::geodetic(one.geodetic), block);
  }
  bug("a measurement without a source");
}

// "P1 (control_plan +1000.21 m)".
std::string label_of(const Measurement& one, double off, const Block& block) {
  std::string text = label_of(one, block) + " (" + std::string(traits_of(one.group).word);
  if (!std::isfinite(off)) return text + ", unseen)";
  const bool in_image = is_image_point(one.group), is_angle = collinea::is_angle(one.group);
  char size[64];
  std::snprintf(size, sizeof size,
                in_image   ? " %+.1f px)"
                : is_angle ? " %+.4f deg)"
                           : " %+.3f m)",
                is_angle ? off * 180 / std::numbers::pi : off);
  return text + size;
}

// The largest suspects of an adjustment, one coordinate of each.
std::vector<std::string> labels_of_suspects(const Examined& adjusted, const Block& block) {
  std::vector<std::string> labels;
  std::set<Measurement> named;
  if (adjusted.reliability)
    for (const TestedObservation& one : adjusted.reliability->suspects)
      if (const Measurement its = measurement_at({one.group, one.source}, block); named.insert(its).second)
        labels.push_back(label_of(its, one.residual, block));
  return labels;
}

// What does not fit.
std::string list_of(const GrossErrors& gross, const Examined* adjusted, const Block& block) {
  std::vector<std::string> labels;
  for (const Rejected& one : gross.measurements) labels.push_back(label_of(one, one.gross_error[one.axis], block));
  if (labels.empty() && adjusted) labels = labels_of_suspects(*adjusted, block);
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, labels.size()); ++i) text += (i == 0 ? "" : ", ") + labels[i];
  return labels.size() > kShown ? text + ", +" + std::to_string(labels.size() - kShown) : text;
}

}  // namespace

Result<> refuse_diverged(const Result<Examined>& adjusted, const Block& block, const AdjustScope& scope,
                         const ExamineOptions& options, const Run& run) {
  if (!is_bent(adjusted, options.test)) return {};
  const Examined* const found = adjusted ? &*adjusted : nullptr;
  const GrossErrors gross = find_gross_errors(block, scope, options.adjust, found, run);
  const std::string list = list_of(gross, found, block);
  const std::string misfits = list.empty() ? "" : "; misfits: " + list;
  if (!found) return tl::unexpected(Error(adjusted.error()).advising(misfits));
  const std::string rays = std::to_string(gross.lost_rays) + " of " + std::to_string(gross.rays);
  if (found->redundancy < 0)
    return fail(Errc::kIllPosed, std::to_string(found->unknown_count) + " unknowns but only " +
                                     std::to_string(found->observation_count) + " observations are left: " + rays +
                                     " image points lie where their image does not see their point" + misfits);
  if (!found->converged) return fail(Errc::kNotConverged, "the adjustment has not converged" + misfits);
  if (gross.lost_rays == 0) return {};
  if (!found->reliability)
    return fail(Errc::kIllPosed, "the observations that are left do not determine the block: " + rays +
                                     " image points lie where their image does not see their point" + misfits);
  if (gross.measurements.empty() && double(gross.lost_rays) < kMostLost * double(gross.rays)) return {};
  return fail(Errc::kNotConverged, "the adjustment has diverged: " + rays +
                                       " image points lie where their image does not see their point" + misfits);
}

Result<Examined> examine_strictly(const Block& block, const AdjustScope& scope, const ExamineOptions& options,
                                  const Run& run) {
  Adjuster adjuster;
  Block adjusted_block = block;
  int adjustments = 0;
  Result<Examined> adjusted = examine_to_the_end(adjuster, adjusted_block, scope, options, run, adjustments);
  COLLINEA_TRY(refuse_diverged(adjusted, block, scope, options, run));
  return adjusted;
}

}  // namespace collinea
