// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/value_words.h"

#include <fmt/format.h>

#include <string_view>

#include "collinea/base/words.h"

namespace collinea {
namespace {

struct GroupWords {
  ObservationGroup group;
  std::string_view words;
};

constexpr GroupWords kGroups[] = {
    {ObservationGroup::kTieImages, "tie points in images"},
    {ObservationGroup::kControlImages, "control in images"},
    {ObservationGroup::kControlPlan, "control, plan"},
    {ObservationGroup::kControlHeight, "control, height"},
    {ObservationGroup::kPositionPlan, "positions, plan"},
    {ObservationGroup::kPositionHeight, "positions, height"},
    {ObservationGroup::kDistance, "distances"},
    {ObservationGroup::kHeightDifference, "height differences"},
    {ObservationGroup::kDirection, "directions"},
    {ObservationGroup::kZenithAngle, "zenith angles"},
    {ObservationGroup::kAtHeight, "equal heights"},
    {ObservationGroup::kOnPlane, "planes"},
    {ObservationGroup::kOnLine, "lines"},
    {ObservationGroup::kAzimuth, "azimuths"},
    {ObservationGroup::kGnssVector, "GNSS vectors"},
    {ObservationGroup::kAttitudeLevel, "attitudes, level"},
    {ObservationGroup::kAttitudeHeading, "attitudes, heading"},
};
static_assert(is_in_order(kGroups, kObservationGroups, &GroupWords::group));

}  // namespace

std::string_view words_of(ObservationGroup group) { return kGroups[static_cast<std::size_t>(group)].words; }

std::string_view words_of(Provenance source) {
  switch (source) {
    case Provenance::kUnknown:
      return "";
    case Provenance::kExifPixelPitch:
      return "EXIF focal length and pixel pitch";
    case Provenance::kExif35mm:
      return "EXIF 35 mm equivalent";
    case Provenance::kAssumed:
      return "assumed";
    case Provenance::kGiven:
      return "given";
    case Provenance::kSimulated:
      return "simulated";
    case Provenance::kTrue:
      return "true";
  }
  return "";
}

std::string_view words_of(HeightReference heights) {
  switch (heights) {
    case HeightReference::kMiddleCamera:
      return "relative, zero at the middle camera";
    case HeightReference::kControlPoints:
      return "as those of the control points";
    case HeightReference::kEllipsoid:
      return "above the WGS 84 ellipsoid";
  }
  return "";
}

NamedValues chosen_options(const ReportInput& input) {
  if (!input.options) return {};
  if (input.options->empty()) return {{"all", "as by default"}};
  return *input.options;
}

std::string fixed_instead_words(const std::vector<std::string>& parameters) {
  std::string names;
  for (const std::string& one : parameters) names += (names.empty() ? "" : ", ") + one;
  return names.empty() ? "" : "fixed, because the additional parameters say the same: " + names;
}

std::string judgement_words(const SigmaFactors& factors, const Eigen::Vector3d& position_shift_m) {
  std::string text;
  for (std::size_t g = 0; g < factors.size(); ++g)
    if (factors[g] != 1)
      text += fmt::format("{}sigmas of \"{}\" times {:.1f}", text.empty() ? "" : ", ", kGroups[g].words, factors[g]);
  if (!position_shift_m.isZero())
    text += fmt::format("{}positions shifted by {:+.2f}, {:+.2f}, {:+.2f} m", text.empty() ? "" : ", ",
                        position_shift_m.x(), position_shift_m.y(), position_shift_m.z());
  return text;
}

}  // namespace collinea
