// SPDX-License-Identifier: Apache-2.0
// Findings on what orientation and adjustment did.
#include <fmt/format.h>

#include <cmath>

#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/finding_sentences.h"
#include "collinea/report/internal/residual_words.h"
#include "collinea/report/internal/systematic_words.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

struct InstrumentWords {
  const char* what;
  const char* axes;  // behind the numbers
  int decimals;      // at least
};

InstrumentWords instrument_of(Aspect aspect) {
  switch (aspect) {
    case Aspect::kLeverArm:
      return {"lever arm", "m to the right, downwards and along the axis", 3};
    case Aspect::kShift:
      return {"shift of positions", "m east, north and up", 3};
    case Aspect::kDrift:
      return {"drift of positions", "m/s east, north and up", 5};
    case Aspect::kBoresight:
      return {"boresight", "degrees about x, y and the optical axis", 4};
    default:
      return {"time offset of positions", "s after the image", 4};
  }
}

std::string listed(const std::vector<double>& values, const char* format, int decimals) {
  std::string text;
  for (const double value : values)
    text += (text.empty() ? "" : ", ") + fmt::format(fmt::runtime(format), value, decimals);
  return text;
}

std::string instrument_words(const FindingWords& w) {
  if (w.finding.subjects.empty()) return "";
  const Subject& subject = w.finding.subjects[0];
  const InstrumentWords words = instrument_of(subject.aspect);
  Subject owner = subject;
  owner.aspect = Aspect::kWhole;
  const std::string whose =
      subject.kind == SubjectKind::kStrip ? fmt::format("strip {}", subject.id + 1) : words_of(owner, w.block);
  const int decimals = decimals_for(w.finding.figures_of(F::kValueSigma), words.decimals);
  return fmt::format("The {} of {} is {} {} (sigma {}).", words.what, whose,
                     listed(w.finding.figures_of(F::kValue), "{:+.{}f}", decimals), words.axes,
                     listed(w.finding.figures_of(F::kValueSigma), "{:.{}f}", decimals));
}

// With unit: px in images, m on the ground, degrees.
std::string gross_error_words(const FindingWords& w) {
  const bool in_image = w.finding.figure(F::kOffsetPx).has_value(),
             angle = w.finding.figure(F::kDifferenceAngle).has_value();
  const char* unit = in_image ? "px" : angle ? "degrees" : "m";
  const double off = w[in_image ? F::kOffsetPx : angle ? F::kDifferenceAngle : F::kOffset];
  const int decimals = in_image ? 1 : angle ? 4 : 3;
  std::string text = fmt::format("{}{} contradicts all else by {:.{}f} {}", w.subject(0),
                                 in_image ? " in " + w.subject(1) : "", off, decimals, unit);
  if (std::isfinite(w[F::kSigma])) text += fmt::format(" (sigma {:.{}f})", w[F::kSigma], decimals + 1);
  text += " and was rejected.";
  if (std::isfinite(w[F::kDifference]) && w[F::kDifference] > 0)
    text += fmt::format(" It had moved the adjusted value by {:.{}f} {}.", w[F::kDifference], decimals, unit);
  return text;
}

}  // namespace

std::string words_of_orientation(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kFewFitGiven:
      return fmt::format(
          "Only {} of {} measurements of tie points {} the poses of {}: these are of other images, or "
          "in another convention, or their cameras are wrong.",
          w.whole(F::kCount), w.whole(F::kOf), w.one() ? "fits" : "fit", w.subject(0));
    case C::kLooseGiven:
      return fmt::format("Fewer than {} tie points fit the pose{} of {}{}. Nothing here speaks for {}.",
                         w.whole(F::kLimit), w.one() ? "" : "s", w.counted(F::kCount, "image"), w.first(0),
                         w.one() ? "this pose" : "these poses");
    case C::kAdditionalFixed:
      return "Poses are fixed as given: no camera gets additional parameters.";
    case C::kAdditionalUncalibrated:
      return "No camera is calibrated: none gets additional parameters.";
    case C::kAdditionalSignificant:
      return fmt::format("Of {}, {} of {} additional parameters {} significant.", w.subject(0), w.whole(F::kCount),
                         w.whole(F::kOf), w.one() ? "is" : "are");
    case C::kInstrument:
      return instrument_words(w);
    case C::kSystematic:
      return systematic_words(w.finding, w.block);
    case C::kSystematicTakenUp:
      return systematic_words(w.finding, w.block) + " It is estimated now.";
    case C::kPositionsInOrder:
    case C::kImageResidualsAlike:
    case C::kResidualDistribution:
      return residual_words(w.finding, w.block);
    case C::kGrossErrorRejected:
      return gross_error_words(w);
    case C::kInstrumentsMore:
      return "Shifts and drifts of other strips that are not listed: " + w.whole(F::kCount) + ".";
    case C::kPartApart:
      return w.one() ? "1 image hangs together with no other: " + w.subject(0) + "."
                     : fmt::format("{} hang together but not with the block: {} ... {}.", w.counted(F::kCount, "image"),
                                   w.subject(0), w.subject(1));
    case C::kImagesAlone:
      return w.counted(F::kCount, "image") + " could not be oriented" + w.first(0) + ".";
    default:
      return "";
  }
}

}  // namespace collinea
