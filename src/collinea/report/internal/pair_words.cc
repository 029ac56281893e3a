// SPDX-License-Identifier: Apache-2.0
// Findings on pairs of images and on independent models.
#include <fmt/format.h>

#include "collinea/base/words.h"
#include "collinea/block/subject_label.h"
#include "collinea/epipolar/pair_shape.h"
#include "collinea/report/internal/finding_sentences.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

// The detail is the word of a weakness, whose meaning is part of a sentence.
std::string geometry_words(const FindingWords& w) {
  std::string_view meaning = w.finding.detail;
  for (const Word<PairWeakness>& entry : words(PairWeakness{}))
    if (entry.word == w.finding.detail) meaning = entry.meaning;
  return fmt::format(
      "The relative orientation is weak: {}. The element that is known worst is known {:.1f} times worse "
      "than if the others were known.",
      meaning, w[F::kRatio]);
}

// Whose they are, where they are not of all.
std::string of_subjects(const FindingWords& w) { return w.finding.subjects.empty() ? "" : " of " + w.all(); }

}  // namespace

std::string words_of_pair(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kPairFewPoints:
      return fmt::format("The relative orientation has {}: fewer than {} leave errors of single points hardly checked.",
                         w.counted(F::kCount, "point"), w.whole(F::kLimit));
    case C::kPairZonesEmpty:
      return fmt::format(
          "In {} of the {} zones of the overlap there is no point of the relative orientation: there it is "
          "extrapolated.",
          w.whole(F::kCount), w.whole(F::kOf));
    case C::kPairParallax:
      return fmt::format(
          "The relative orientation leaves y-parallaxes of {:.2f} px (sigma0), where points of such matching leave "
          "{:.2f} px. Its images have a distortion, a principal point or a deformation that nothing states.",
          w[F::kOffsetPx], w[F::kSigmaPx]);
    case C::kPairGeometry:
      return geometry_words(w);
    case C::kPairBase:
      return fmt::format(
          "Heights are known to {:.3g} m, where {:.3g} m are wanted: the base is {:.2f} of the distance.", w[F::kSigma],
          w[F::kWanted], w[F::kRatio]);
    case C::kPairControlApart:
      return fmt::format(
          "There is no control in {} of the {} quarters of the overlap: what lies there is extrapolated.",
          w.whole(F::kCount), w.whole(F::kOf));
    case C::kPairLevelsDropped:
      return fmt::format(
          "{} of {} levels of the surface {} dropped: fewer than {} points do not take the place of the level "
          "before.{}",
          w.whole(F::kCount), w.whole(F::kOf), w.one() ? "was" : "were", w.whole(F::kLimit),
          w[F::kCount] == w[F::kOf] ? " The surface is that of the points of the relative orientation." : "");
    case C::kPairCellsMeasured:
      return fmt::format("Of the cells of the surface model {} are measured; the others are interpolated or empty.",
                         w.percent(F::kShare, "{:.0f} %"));
    default:
      return "";
  }
}

std::string words_of_models(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kModelNoPoint:
      return "The " + w.subject(0) + " was left out: it has no point in common with the others.";
    case C::kModelTurns:
      return fmt::format("The {} was left out: it hangs by {} only, about which it can turn.", w.subject(0),
                         w.one() ? "one point" : "two points");
    case C::kModelNotFixed:
      return fmt::format(
          "The {} was left out: its {} points in common with the others do not fix it; they lie on a line, or are "
          "known in plan or height alone.",
          w.subject(0), w.whole(F::kCount));
    case C::kModelNoControl:
      return "The " + w.subject(0) +
             " was left out: it hangs together with other models but not with the block, and what control these have "
             "does not fix them.";
    case C::kModelFewPoints:
      return fmt::format("The {} is tied to the others by {}: fewer than {} hardly check each other.", w.subject(0),
                         w.counted(F::kCount, "point"), w.whole(F::kLimit));
    case C::kModelPointsOnLine:
      return fmt::format(
          "The {} points by which the {} is tied lie near a line ({:.0f} % as wide as long): it can hardly be kept "
          "from "
          "turning about it.",
          w.whole(F::kCount), w.subject(0), 100 * w[F::kRatio]);
    case C::kModelUnchecked:
      return fmt::format("The {} is checked by nothing: its redundancy is {:.2f}.", w.subject(0), w[F::kValue]);
    case C::kPairMakesNoModel:
      return "The pair " + w.all() + " makes no model: " + w.finding.detail + ".";
    default:
      return "";
  }
}

std::string words_of_fit(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kControlContradicts:
      return fmt::format(
          "Control point {} contradicts the others in {} by {:.3g} m: its test |w| is {:.1f}, the limit {:.1f}. It "
          "takes part all the same.",
          name_in_block(w.finding.subjects.at(0), w.block), "XYZ"[w.finding.subjects[0].axis % 3], w[F::kOffset],
          w[F::kTest], w[F::kLimit]);
    case C::kResidualsLarge:
      return fmt::format(
          "Residuals{} are {:.2g} times as large as the stated standard deviations let expect (chance of so much or "
          "more "
          "{:.1g}): something is wrong, or they are stated too small.",
          of_subjects(w), w[F::kRatio], w[F::kChance]);
    case C::kResidualsSmall:
      return fmt::format(
          "Residuals{} are {:.2g} of what the stated standard deviations let expect (chance of so little or less "
          "{:.1g}): they are stated too large, or are not independent.",
          of_subjects(w), w[F::kRatio], w[F::kChance]);
    default:
      return "";
  }
}

}  // namespace collinea
