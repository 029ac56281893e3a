// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/value_words.h"

#include <fmt/format.h>

#include <array>

namespace collinea {
namespace {

constexpr std::array<std::string_view, kObservationGroups> kGroups = {"tie points in images",
                                                                      "control in images",
                                                                      "control, plan",
                                                                      "control, height",
                                                                      "positions, plan",
                                                                      "positions, height",
                                                                      "distances",
                                                                      "height differences",
                                                                      "directions",
                                                                      "zenith angles",
                                                                      "equal heights",
                                                                      "planes",
                                                                      "lines",
                                                                      "attitudes, level",
                                                                      "attitudes, heading"};

}  // namespace

std::string_view words_of(ObservationGroup group) { return kGroups[static_cast<std::size_t>(group)]; }

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

std::string judgement_words(const SigmaFactors& factors, const Eigen::Vector3d& position_shift_m) {
  std::string text;
  for (std::size_t g = 0; g < factors.size(); ++g)
    if (factors[g] != 1)
      text += fmt::format("{}sigmas of \"{}\" times {:.1f}", text.empty() ? "" : ", ", kGroups[g], factors[g]);
  if (!position_shift_m.isZero())
    text += fmt::format("{}positions shifted by {:+.2f}, {:+.2f}, {:+.2f} m", text.empty() ? "" : ", ",
                        position_shift_m.x(), position_shift_m.y(), position_shift_m.z());
  return text;
}

}  // namespace collinea
