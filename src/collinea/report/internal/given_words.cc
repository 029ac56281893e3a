// SPDX-License-Identifier: Apache-2.0
// Findings on what is given and on what is made: images and files, products and exchange.
#include <fmt/format.h>

#include "collinea/report/finding_words.h"
#include "collinea/report/internal/finding_sentences.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

std::string focal_words(const FindingWords& w) {
  return fmt::format(
      "{} ({} x {} px) has {} focal length in its files. {} px are assumed, to be found by self-calibration.",
      w.subject(0), w.whole(F::kWidth), w.whole(F::kHeight),
      w.finding.code == C::kFocalAssumed ? "no" : "an impossible", w.whole(F::kFocal));
}

std::string orientation_words(const FindingWords& w) {
  return fmt::format("{} of {} of {} images {} taken from {}, and {}.",
                     w[F::kCameras] > 0 ? "Orientation and camera" : "Orientation", w.whole(F::kCount), w.whole(F::kOf),
                     w[F::kCameras] > 0 ? "are" : "is", w.subject(0),
                     w.finding.code == C::kOrientationFixed ? "fixed as given" : "adjusted");
}

}  // namespace

std::string words_of_given(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kFocalAssumed:
    case C::kFocalImpossible:
      return focal_words(w);
    case C::kHeightsCountFrom:
      return fmt::format("Heights of the images count from {}: {:.2f} to {:.2f} m over the ellipsoid here.",
                         w.subject(0), w[F::kLowest], w[F::kHighest]);
    case C::kPositionsOfOthers:
    case C::kPositionsAmbiguous:
      return fmt::format("{} of {} images of {} {} not among the images here{}.{}", w.whole(F::kCount), w.whole(F::kOf),
                         w.subject(0), w.one() ? "is" : "are", w.first(1),
                         w.finding.code == C::kPositionsAmbiguous ? " Several images end in one number." : "");
    case C::kPositionsNotStated:
      return fmt::format("{} of {} images {} not in {} and {}.", w.whole(F::kCount), w.whole(F::kOf),
                         w.one() ? "is" : "are", w.subject(0),
                         w.one() ? "keeps what its header states" : "keep what their headers state");
    case C::kTimesOfHeaders:
      return "Times are taken from the headers of the images, because " + w.subject(0) +
             " does not state those of all.";
    case C::kCamerasMerged:
      return fmt::format(
          "{} gives the images of {} different cameras (f from {:.1f} to {:.1f} px). The middle one is "
          "taken for all, and poses fit it only roughly.",
          w.subject(0), w.subject(1), w[F::kFocalLowest], w[F::kFocalHighest]);
    case C::kOrientationTaken:
    case C::kOrientationFixed:
      return orientation_words(w);
    case C::kImageUnreadable:
    case C::kImageTooSmall:
    case C::kImageDuplicate:
    case C::kScanNotOriented:
      return "Image " + w.subject(0) + " is skipped: " + reason_of(w.finding, w.block) + ".";
    case C::kScanMarksDisagree:
      return fmt::format(
          "Scan {}: its {} fiducial marks miss the calibration by {:.2f} px in the root mean square{}. Its "
          "image coordinates may be off by as much.",
          w.subject(0), w.whole(F::kOf), w[F::kOffsetPx],
          w[F::kCount] > 0 ? fmt::format(", and {} left out as misread", w.whole(F::kCount)) : "");
    case C::kFolderUnreadable:
      return "Folder " + w.subject(0) + " is skipped: " + reason_of(w.finding, w.block) + ".";
    default:
      return "";
  }
}

std::string words_of_products(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kNoDepthMap:
      return "Image " + w.subject(0) + " has no depth map: " + w.finding.detail + ".";
    case C::kNotDownwards:
      return "The images do not look down on the scene: no " + w.subject(0) + ".";
    case C::kNoScale:
      return "The block has no scale, so that the size of objects is not known: no " + w.subject(0) + ".";
    case C::kNoGround:
      return "Nothing in the surface model is ground: no " + w.subject(0) + ".";
    case C::kNoPreview:
      return "There is no preview of " + w.subject(0) + ": " + w.finding.detail + ".";
    case C::kProjectionFitted:
      return fmt::format("Camera {}: its equisolid projection is fitted by a polynomial of the angle, to {:.4f} px.",
                         w.subject(0), w[F::kOffsetPx]);
    case C::kShearDropped:
      return fmt::format("Camera {}: its shear b2 = {:.3f} px is left out, up to {:.3f} px at the image's edge.",
                         w.subject(0), w[F::kValue], w[F::kOffsetPx]);
    case C::kAdditionalDropped:
      return fmt::format(
          "Camera {}: its additional parameters ({}) are left out, up to {:.3f} px. The image "
          "coordinates of tie points are freed from them, the images are not.",
          w.subject(0), w.finding.detail, w[F::kOffsetPx]);
    case C::kImagesNotExported:
      return w.counted(F::kCount, "image") + " without orientation " + (w.one() ? "is" : "are") + " left out.";
    case C::kDistortionFitted:
      return fmt::format(
          "Bundler's camera has its principal point in the middle and two radial terms: image "
          "coordinates were corrected by up to {:.3f} px for what it cannot hold, the images were not.",
          w[F::kOffsetPx]);
    default:
      return "";
  }
}

}  // namespace collinea
