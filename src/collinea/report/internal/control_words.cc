// SPDX-License-Identifier: Apache-2.0
// Findings on control, on how it was measured in images, and on positions.
#include <fmt/format.h>

#include <cmath>

#include "collinea/quality/mark_systems.h"
#include "collinea/report/internal/finding_sentences.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

std::string wrong_point(const FindingWords& w, const char* judge) {
  const double plan = w[F::kOffsetPlan], height = std::abs(w[F::kOffsetHeight]), off = w[F::kOffset];
  const char* where = plan < 0.2 * height ? " in height" : height < 0.2 * plan ? " in plan" : "";
  return fmt::format("The coordinates of {} differ by {:.{}f} m{} from what {} show. The point is not used.",
                     w.subject(0), off, off < 10 ? 2 : 1, where, judge);
}

std::string marks_counted(const Finding& finding) {
  const double factor = finding.figure(F::kRatio).value_or(1);
  const double sigma = factor * finding.figure(F::kSigmaScale).value_or(0);
  switch (from_word<MarkSystem>(finding.detail).value_or(MarkSystem::kAsGiven)) {
    case MarkSystem::kAsGiven:
      break;
    case MarkSystem::kRowsUp:
      return "with rows counted upwards";
    case MarkSystem::kColumnsLeft:
      return "with columns counted to the left";
    case MarkSystem::kUpsideDown:
      return "turned by 180 degrees";
    case MarkSystem::kExchanged:
      return "with columns and rows exchanged";
    case MarkSystem::kTurnedRight:
      return "as measured in images that were shown turned to the right";
    case MarkSystem::kTurnedLeft:
      return "as measured in images that were shown turned to the left";
    case MarkSystem::kCentre:
      return "counted from the middle of the images";
    case MarkSystem::kCentreRowsUp:
      return "counted from the middle of the images, rows upwards";
    case MarkSystem::kResampled:
      return fmt::format("as measured in images of another size, all times {:.5g} +- {:.1g}", factor, sigma);
    case MarkSystem::kResampledRowsUp:
      return fmt::format("as measured in images of another size, all times {:.5g} +- {:.1g}, with rows counted upwards",
                         factor, sigma);
    case MarkSystem::kScaledCentre:
      return fmt::format("as measured from the middle of the images with {:.5g} +- {:.1g} pixels to their unit", factor,
                         sigma);
    case MarkSystem::kScaledCentreRowsUp:
      return fmt::format(
          "as measured from the middle of the images, upwards, with {:.5g} +- {:.1g} pixels to their unit", factor,
          sigma);
  }
  return "otherwise";
}

}  // namespace

std::string words_of_marks(const FindingWords& w) {
  const auto counts = w.finding.figures_of(F::kCount);
  switch (w.finding.code) {
    case C::kMarksCountedOtherwise:
      return fmt::format(
          "Image measurements of control fit the images {}: {} of {} then meet the others within {:.1f} px, as given "
          "{:.0f}.",
          marks_counted(w.finding), w.whole(F::kCount), w.whole(F::kOf), w[F::kOffsetPx],
          counts.size() > 1 ? counts[1] : 0);
    case C::kMarksCorrected:
      return fmt::format("Image measurements of control are used {}.", marks_counted(w.finding));
    case C::kMarksOutside:
      return fmt::format(
          "{} of {} image measurements of control lie outside their images: they were not counted in pixels from the "
          "upper-left corner of these. Orientation looks for the way in which they were.",
          w.whole(F::kCount), w.whole(F::kOf));
    case C::kMarksMirrored:
      if (w[F::kRatio] < 3)
        return fmt::format(
            "The cameras of {} images stand beneath all control that they show. With the image measurements {} they "
            "stand above it, and miss it by {:.1f} px.",
            w.whole(F::kOf), marks_counted(w.finding), w[F::kOffsetPx]);
      return fmt::format(
          "{} of {} images fit control better with the image measurements {}: they miss it by {:.1f} px, {:.2g} times "
          "less than as given.",
          w.whole(F::kCount), w.whole(F::kOf), marks_counted(w.finding), w[F::kOffsetPx], w[F::kRatio]);
    default:
      return "";
  }
}

std::string words_of_measured_control(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kControlOutsideImage:
      return fmt::format("Control {} in {} (line {}): pixel {:.1f}, {:.1f} lies outside the image. It is left out.",
                         w.subject(0), w.subject(1), w.whole(F::kLine), w[F::kPixelX], w[F::kPixelY]);
    case C::kControlImageMissing:
      return fmt::format("Control file: no image is called {} ({} left out).", w.subject(0),
                         w.counted(F::kCount, "measurement"));
    case C::kEditUnfit:
      return fmt::format("Edit {} does not fit what was imported and is left out: {}.", w.whole(F::kLine),
                         w.finding.detail);
    case C::kControlNotGiven:
      return "A file of control lies beside the images and is not used: " + w.subject(0) + ".";
    case C::kControlUnseen:
      return "Control " + w.subject(0) + " is seen in no image: it cannot be used.";
    case C::kCheckSeenOnce:
      return "Check point " + w.subject(0) + " is seen in 1 image: it cannot be compared.";
    case C::kControlSeenOnce:
      return "Control " + w.subject(0) + " is seen in 1 image: a gross error in it would not show.";
    case C::kControlMeasurement:
      return fmt::format("{} in {} is off by {} px: the other images see it elsewhere. This measurement is not used.",
                         w.subject(0), w.subject(1), w.whole(F::kOffsetPx));
    case C::kControlMeasurementsDisagree:
      return fmt::format(
          "The measurements of {} in {} images miss each other by up to {} px, and too few are there to "
          "tell which is wrong. The point is not used.",
          w.subject(0), w.whole(F::kCount), w.whole(F::kOffsetPx));
    case C::kControlMeasurementSigma:
      return fmt::format(
          "Image measurements of control points miss each other by {:.1f} times their sigma. It is taken "
          "as {:.2g} px.",
          w[F::kRatio], w[F::kSigmaPx]);
    default:
      return "";
  }
}

std::string words_of_control(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kControlPoint:
      return wrong_point(w, "the other points");
    case C::kControlPointByPositions:
      return wrong_point(w, "the other points and the positions of the images");
    case C::kCheckPoint:
      return fmt::format(
          "Check point {} contradicts the control points: its coordinates differ by {:.1f} m from what they show. Look "
          "at its coordinates and at its measurements.",
          w.subject(0), w[F::kOffset]);
    case C::kControlInconsistent:
      return fmt::format("{} contradict each other by {:.1f} m by the positions of the images: one of them is wrong.",
                         w.all(), w[F::kOffset]);
    case C::kControlAxesSwapped:
      return "The control fits the images only with eastings and northings exchanged: its columns are in the other "
             "order.";
    case C::kControlAxesExchanged:
      return "Eastings and northings of the control are used exchanged back.";
    case C::kControlSigmaPlan:
    case C::kControlSigmaHeight:
      return fmt::format(
          "Control points contradict the images by {:.1f} times their sigma in {}. It is taken as {:.2g} "
          "m.",
          w[F::kRatio], w.finding.code == C::kControlSigmaPlan ? "plan" : "height", w[F::kSigma]);
    case C::kDistancesContradict:
      return fmt::format("The distances {} contradict each other by {}: one of them, or a point of it, is wrong.",
                         w.all(), w.percent(F::kRelative));
    case C::kDistanceWrong:
      return fmt::format("The {} contradicts the other distances by {} ({:.3g} m): it is not used.", w.subject(0),
                         w.percent(F::kRelative), w[F::kDifference]);
    case C::kGeodeticDiffers:
    case C::kGeodeticAngleDiffers: {
      const bool angle = w.finding.code == C::kGeodeticAngleDiffers;
      return fmt::format("On the ground, {} differs from the adjusted block by {:.3g} {}, {} times what is expected.",
                         w.subject(0), w[angle ? F::kDifferenceAngle : F::kDifference], angle ? "degrees" : "m",
                         w.whole(F::kRatio));
    }
    default:
      return "";
  }
}

std::string words_of_positions(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kPositionCrs:
      return fmt::format(
          "The positions of the images lie {:.1f} km from the control: the coordinate system of the "
          "control is not the one that was named, or its columns are mixed up. Positions are not used.",
          w[F::kOffset] / 1000);
    case C::kPositionOffset:
      return fmt::format(
          "The positions of the images lie {:.1f} m off the control in plan (east {:+.1f}, north {:+.1f}). "
          "Control is used, positions are not.",
          w[F::kOffset], w[F::kEast], w[F::kNorth]);
    case C::kPositionHeights:
      return fmt::format(
          "GPS heights lie {:.1f} m {} the control heights (another height reference?). Heights of "
          "control are used.",
          std::abs(w[F::kUp]), w[F::kUp] > 0 ? "above" : "below");
    case C::kPositionsShifted:
      return fmt::format(
          "Control points contradict the positions of the images, which were shifted by {:+.2f} m east, "
          "{:+.2f} m north and {:+.2f} m up: control decides the position of the block. Their "
          "differences are stated without this shift.",
          w[F::kEast], w[F::kNorth], w[F::kUp]);
    case C::kPositionOutweighs:
      return fmt::format(
          "The position of {} lies {:.1f} m from where the others put it. With its sigma of {:.3g} m it would outweigh "
          "them all: it was left out.",
          w.subject(0), w[F::kOffset], w[F::kSigma]);
    case C::kPositionsUnused:
      return "Positions are not used here, and so no lever arm, shift or time offset of them.";
    case C::kAttitudesUnused:
      return "The block has no position on Earth to which attitudes could refer: they are not used.";
    case C::kShiftUnused:
      return "No control point separates a shift of the positions from one of the block: they are taken as measured.";
    default:
      return "";
  }
}

}  // namespace collinea
