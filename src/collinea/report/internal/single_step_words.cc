// SPDX-License-Identifier: Apache-2.0
// Findings of single steps of orientation.
#include <fmt/format.h>

#include <cmath>

#include "collinea/report/internal/finding_sentences.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

// " (A, B)" where there are subjects from the i-th on.
std::string in_brackets(const FindingWords& w, std::size_t from = 0) {
  return w.finding.subjects.size() > from ? " (" + w.from(from) + ")" : "";
}

const char* were(const FindingWords& w) { return w.one() ? "was" : "were"; }

}  // namespace

std::string words_of_measured(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kNothingChecks:
      return w.finding.subjects.empty() ? "There are as many measurements as unknowns: nothing checks the result."
                                        : "There are as many measurements as unknowns: nothing checks " + w.all() + ".";
    case C::kMeasurementContradicts:
      return fmt::format(
          "The measurement of point {}{} contradicts the others: its test |w| is {:.2f}, the limit {:.2f}. It takes "
          "part all the same.",
          w.subject(0), w.finding.subjects.size() > 1 ? " in " + w.subject(1) : "", w[F::kTest], w[F::kLimit]);
    case C::kMeasurementsRejected:
      return fmt::format("Of {} measured points {} {} rejected, because they contradict the others{}.", w.whole(F::kOf),
                         w.whole(F::kCount), were(w), in_brackets(w));
    case C::kControlRejected:
      return fmt::format("Of {} control points {} {} rejected, because they contradict the others{}.", w.whole(F::kOf),
                         w.whole(F::kCount), were(w), in_brackets(w));
    case C::kFewPoints:
      return fmt::format("The orientation rests on {}: fewer than {} hardly check each other.",
                         w.counted(F::kCount, "point"), w.whole(F::kLimit));
    case C::kControlFew:
      return fmt::format(
          "The control is {} known in X, Y and Z and {} known in height alone: four and a further height are the least "
          "that check each other.",
          w.counted(F::kCount, "point"), w.counted(F::kHeights, "point"));
    case C::kControlOnLine:
      return fmt::format(
          "The {} control points lie near a line ({:.0f} % as wide as long): the tilt about it is hardly determined.",
          w.whole(F::kCount), 100 * w[F::kRatio]);
    default:
      return "";
  }
}

std::string words_of_poses(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kSolutionsOpen:
      return fmt::format("There are {} orientations that fit as well: nothing decides between them{}.",
                         w.whole(F::kCount), in_brackets(w));
    case C::kSolutionChosen:
      return fmt::format(
          "There are {} orientations that fit the points as well{}; the other measurements, or the position that was "
          "given, decide.",
          w.whole(F::kCount), in_brackets(w));
    case C::kPointsBehind:
      return fmt::format("The rays of {} of {} points meet behind an image.", w.whole(F::kCount), w.whole(F::kOf));
    case C::kPoseWeak:
      return fmt::format(
          "The control hardly determines the pose of {}: the smallest eigenvalue of its normal matrix is {:.1g} of the "
          "largest.",
          w.all(), w[F::kRatio]);
    case C::kDangerCircle:
      return fmt::format(
          "The control of {} lies on a circle of radius {:.4g} m, and the station is {:.3g} m from it or from the "
          "cylinder over it: there the resection is undetermined.",
          w.all(), w[F::kRadius], w[F::kOffset]);
    case C::kPoseOpen:
      return "No pose of " + w.all() + " follows from the transformation alone.";
    case C::kCombinationsOpen:
      return fmt::format(
          "Of the 16 combinations of both pairs {} are acceptable, where two are expected, mirror images of each "
          "other: points are few, or their rays nearly parallel.",
          w.whole(F::kCount));
    default:
      return "";
  }
}

std::string words_of_rays(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kSeenOnce:
      return fmt::format("{} seen in one oriented image only, which gives no depth{}.",
                         w.one() ? "One point is" : w.whole(F::kCount) + " points are", in_brackets(w));
    case C::kRaysWithoutPoint:
      return fmt::format("{} no position, because rays are parallel or meet behind an image{}.",
                         w.one() ? "One point has" : w.whole(F::kCount) + " points have", in_brackets(w));
    case C::kRaysNarrow:
      return fmt::format(
          "The rays of {} meet at less than {:.1f} degrees (the smallest angle is {:.2f}): depth is known far worse "
          "than the position across{}.",
          w.counted(F::kCount, "point"), w[F::kLimit], w[F::kAngle], in_brackets(w));
    case C::kRaysMiss:
      return fmt::format(
          "The two rays of {} do not meet (the largest |w| is {:.1f}, the limit {:.2f}), and two rays do not tell "
          "which "
          "is wrong{}.",
          w.counted(F::kCount, "point"), w[F::kTest], w[F::kLimit], in_brackets(w));
    case C::kOrientationsExact:
      return "The orientations are taken as exact, because their table states no standard deviations: those of the "
             "points hold the errors of their measurements alone.";
    default:
      return "";
  }
}

std::string words_of_uncalibrated(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kRankNearThree:
      return fmt::format(
          "The measurements hardly have rank 4: the fourth singular value is {:.2g} times the fifth, which is noise. "
          "The points lie near a plane, or the images were taken from nearly one centre.",
          w[F::kRatio]);
    case C::kNotInAllImages:
      return fmt::format("Of {} points {} {} left out, because not all images show them{}.", w.whole(F::kOf),
                         w.whole(F::kCount), were(w), in_brackets(w));
    case C::kOneCalibrationRefuted:
      return fmt::format(
          "One calibration for all images costs more than errors of measurement allow (F {:.2f}, chance {:.1g}): lens "
          "distortion, another camera, or gross errors.",
          w[F::kRatio], w[F::kChance]);
    case C::kStatedCameraRefuted:
      return fmt::format(
          "The stated camera costs more than errors of measurement allow (F {:.2f}, chance {:.1g}) against the "
          "self-calibrated one: its principal distance or principal point is another, or its pixels are not square.",
          w[F::kRatio], w[F::kChance]);
    case C::kNoEuclideanForm:
      return "Cameras and points are known up to a projectivity only: " + w.finding.detail + ".";
    case C::kCameraFitsNot:
      return "There is no orientation with the stated camera: " + w.finding.detail + ".";
    case C::kPrincipalDistanceWeak:
      return fmt::format(
          "Self-calibration hardly determines the principal distance: its standard deviation is {:.0f} % of it.",
          100 * w[F::kRelative]);
    default:
      return "";
  }
}

std::string words_of_fiducials(const FindingWords& w) {
  // The image comes first, which may have no name; then its marks.
  const bool is_named =
      w.finding.subjects.empty() || w.finding.subjects[0].id != Subject::kAll || !w.finding.subjects[0].name.empty();
  const std::string image = is_named ? w.subject(0) : "the image";
  switch (w.finding.code) {
    case C::kFiducialsContradict:
      return fmt::format(
          "The marks of {} contradict each other by far more than film or readings do{}{}.", image,
          w.finding.figure(F::kOffset) ? fmt::format(": by {:.3g} mm on the film", 1e3 * w[F::kOffset]) : "",
          w.finding.figure(F::kRatio) ? fmt::format(": {:.1f} times the sigmas given", w[F::kRatio]) : "");
    case C::kFiducialsLeftOut:
      return fmt::format("Of the {} marks of {} {} {} left out as misread{}.", w.whole(F::kOf), image,
                         w.whole(F::kCount), were(w), in_brackets(w, 1));
    case C::kFiducialsMissing:
      return fmt::format("Of the {} marks of the calibration {} {} not measured in {}{}.", w.whole(F::kOf),
                         w.whole(F::kCount), were(w), image, in_brackets(w, 1));
    case C::kFiducialsUnknown:
      return fmt::format("In {} {} measured that the calibration does not have{}.", image,
                         w.one() ? "a mark was" : w.whole(F::kCount) + " marks were", in_brackets(w, 1));
    case C::kReadingsContested:
      return fmt::format("The readings of {} in {} differ beyond their limit, and none is outvoted{}.",
                         w.counted(F::kCount, "mark"), image, in_brackets(w, 1));
    case C::kReadingsGross:
      return fmt::format("Of the readings in {} {} {} left out as gross{}.", image, w.whole(F::kCount), were(w),
                         in_brackets(w, 1));
    case C::kSeenFromBehind:
      return "Rows of " + image + " are counted from below, or the film was scanned from its back.";
    default:
      return "";
  }
}

}  // namespace collinea
