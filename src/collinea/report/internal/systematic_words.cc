// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/systematic_words.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "collinea/block/subject_label.h"
#include "collinea/camera/additional.h"
#include "collinea/io/text.h"

namespace collinea {
namespace {

using F = FigureName;
constexpr double kLeastChance = 1e-99;  // smaller ones are no figure that anybody compares
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct KindWords {
  std::string what;    ///< "a time offset of the positions of FC6310"
  const char* unit;    ///< and the axes of its values
  const char* format;  ///< of a value; empty: values are not listed
};

std::string owner_of(const Subject& subject, const Block& block) {
  if (subject.kind == SubjectKind::kStrip) return fmt::format("strip {}", subject.id + 1);
  return subject.kind == SubjectKind::kCamera ? name_in_block(subject, block) : "the whole flight";
}

KindWords kind_of(const Subject& subject, const Block& block) {
  const std::string whose = owner_of(subject, block);
  switch (subject.aspect) {
    case Aspect::kTimeOffset:
      return {"a time offset of the positions of " + whose, "s after the images", "{:+.4f}"};
    case Aspect::kLeverArm:
      return {"a lever arm between camera and antenna of " + whose, "m to the right, downwards and along the axis",
              "{:+.3f}"};
    case Aspect::kShift:
      return {"a shift of the positions of " + whose, "m east, north and up", "{:+.3f}"};
    case Aspect::kDrift:
      return {"a drift of the positions of " + whose, "m east, north and up from its first to its last image",
              "{:+.3f}"};
    case Aspect::kBoresight:
      return {"a boresight between attitudes and images of " + whose, "degrees about x, y and the optical axis",
              "{:+.4f}"};
    case Aspect::kVerticalDatum:
      return {"another vertical datum of positions than of control", "m", "{:+.3f}"};
    case Aspect::kAssignment:
      return {subject.axis == 0 ? "positions that are those of the next image"
                                : "positions that are those of the previous image",
              "images further", "{:+.2f}"};
    case Aspect::kBowl:
      return {"a bowl of the block's heights", "m at its rim against its middle", "{:+.3f}"};
    case Aspect::kAffinity:
      return {"an affinity (b1, b2) of " + whose, "px", "{:+.2f}"};
    case Aspect::kAdditional:
      return {fmt::format("an image deformation of {} that the additional parameters \"{}\" describe", whose,
                          word_of(static_cast<AdditionalSet>(subject.axis))),
              "", ""};
    case Aspect::kRollingShutter:
      return {"a rolling shutter of " + whose, "s from the first to the last row", "{:+.4f}"};
    case Aspect::kRefraction:
      return {"refraction in the measurements", "of that of a standard atmosphere", "{:+.2f}"};
    default:
      return {"a systematic error", "", ""};
  }
}

std::string listed(const std::vector<double>& values, const char* format) {
  std::string text;
  for (const double value : values)
    text += (text.empty() ? "" : ", ") +
            (std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : std::string("unknown"));
  return text;
}

std::string chance_words(double chance) {
  return chance < kLeastChance ? "hardly ever" : fmt::format("with a chance of {:.1g}", chance);
}

std::string displaced(const Finding& finding) {
  const Aspect aspect = finding.subjects[0].aspect;
  if (const auto px = finding.figure(F::kOffsetPx);
      px && (aspect == Aspect::kAffinity || aspect == Aspect::kAdditional))
    return fmt::format("residuals of image points by up to {:.2f} px", *px);
  if (const auto px = finding.figure(F::kOffsetPx)) return fmt::format("image points by up to {:.2f} px", *px);
  if (const auto deg = finding.figure(F::kDifferenceAngle))
    return fmt::format("attitudes by up to {:.3f} degrees", *deg);
  return "positions and heights that are given by up to " + metres_text(finding.figure(F::kOffset).value_or(kNaN));
}

}  // namespace

std::string systematic_name(const Subject& subject, const Block& block) { return kind_of(subject, block).what; }

std::string systematic_words(const Finding& finding, const Block& block) {
  if (finding.subjects.empty()) return "";
  const KindWords kind = kind_of(finding.subjects[0], block);
  const std::vector<double> values = finding.figures_of(F::kValue), sigmas = finding.figures_of(F::kValueSigma);
  std::string text = "The residuals show " + kind.what;
  if (*kind.format && !values.empty())
    text +=
        fmt::format(": {} {} (sigma {})", listed(values, kind.format), kind.unit,
                    listed(sigmas, kind.format[3] == '.' ? (std::string("{:") + (kind.format + 3)).c_str() : "{:.3f}"));
  text += fmt::format(". By accident they do so {}. It changes {}; to estimate it moves points by up to {}.",
                      chance_words(finding.figure(F::kChance).value_or(kNaN)), displaced(finding),
                      metres_text(finding.figure(F::kDifference).value_or(kNaN)));
  std::string others;
  for (std::size_t i = 1; i < finding.subjects.size(); ++i)
    others += (i == 1                             ? ""
               : i + 1 == finding.subjects.size() ? " or "
                                                  : ", ") +
              kind_of(finding.subjects[i], block).what;
  if (!others.empty()) text += " On this block it may as well be " + others + ".";
  return text;
}

}  // namespace collinea
