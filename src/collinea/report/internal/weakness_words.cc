// SPDX-License-Identifier: Apache-2.0
// Findings on the datum of a block and on what is determined badly.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "collinea/report/internal/finding_sentences.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

std::string axis_words(const FindingWords& w) {
  if (w[F::kSteepness] > 0.9) return "the vertical";
  return fmt::format("a{} axis with the azimuth {:.0f} degrees", w[F::kSteepness] < 0.3 ? " level" : "n inclined",
                     w[F::kAzimuth]);
}

std::string datum_defect_words(const FindingWords& w) {
  std::vector<std::string> what;
  std::string part;
  std::vector<Subject> control;
  for (const Subject& subject : w.finding.subjects) {
    if (subject.control())
      control.push_back(subject);
    else if (subject.image())
      part = " of the part with " + words_of(subject, w.block);
    else
      what.push_back(words_of(subject, w.block));
    if (subject.aspect == Aspect::kRotation)
      what.back() = "the rotation about " + axis_words(w) +
                    (w[F::kSteepness] > 0.9 ? "" : ", the line on which all that is known lies");
  }
  if (control.size() == 2)
    for (std::string& one : what)
      if (one.starts_with("the rotation")) one = "the rotation about the line through " + words_of(control, w.block);
  std::string text;
  for (std::size_t i = 0; i < what.size(); ++i) text += (i == 0 ? "" : i + 1 == what.size() ? " and " : ", ") + what[i];
  if (control.size() == 1) text += " (there is one control point: " + words_of(control[0], w.block) + ")";
  return "Nothing fixes " + text + part + ".";
}

std::string level_words(const FindingWords& w, LevelSource by) {
  return fmt::format(
      "Positions of images {}: what is level comes from {}, good to about {:.0f} degrees. The scale is "
      "good to {}, north to {:.2g} degrees.",
      w[F::kHeights] > 0 ? "reach too little for their errors to tell how the block is tilted" : "have no heights",
      words_of(by), std::max(1.0, w[F::kSigmaAngle]), w.percent(F::kSigmaScale), w[F::kSigmaAzimuth]);
}

std::string motion_words(const FindingWords& w) {
  return fmt::format(
      "which shifts what lies {:.3g} m from the middle by {:.2g} m, while what fixes it is known to "
      "{:.2g} m",
      w[F::kExtent], w[F::kMotion], w[F::kReference]);
}

// The first subject is a motion of images; the others are parameters, each with its correlation.
std::string mixture_words(const FindingWords& w) {
  const std::vector<double> correlations = w.finding.figures_of(F::kCorrelation);
  const std::size_t count = std::min(correlations.size(), w.finding.subjects.size() - 1);
  std::string mixed;
  for (std::size_t i = 0; i < count; ++i)
    mixed += fmt::format("{}{} ({:+.3f})",
                         i == 0           ? ""
                         : i + 1 == count ? " and "
                                          : ", ",
                         param_name(w.finding.subjects[i + 1].axis), correlations[i]);
  const auto camera = w.finding.subjects[0].camera();
  return fmt::format(
      "Of camera {}, {} and {} can hardly be separated (correlations in brackets). The former is known "
      "{} times worse than with a known camera.",
      camera ? words_of(*camera, w.block) : "", w.subject(0), mixed.empty() ? "its parameters together" : mixed,
      w.whole(F::kRatio));
}

std::string undetermined_parameters(const FindingWords& w) {
  std::string parameters;
  bool with_height = false;
  std::size_t count = 0;
  for (const Subject& subject : w.finding.subjects) {
    with_height |= subject.aspect == Aspect::kDistance;
    if (subject.aspect == Aspect::kParameter) parameters += (count++ ? ", " : "") + param_name(subject.axis);
  }
  const auto camera = w.finding.subjects.empty() ? std::nullopt : w.finding.subjects[0].camera();
  return fmt::format("The measurements do not determine {} of camera {}: {} to what was assumed before.{}", parameters,
                     camera ? words_of(*camera, w.block) : "",
                     count > 1 ? "they owe their values" : "it owes its value",
                     with_height ? " Height and focal length cannot be separated." : "");
}

std::string focal_undetermined(const FindingWords& w, const char* cause) {
  return fmt::format(
      "The focal length of {} is hardly determined by the images ({}): {}. Distances across the view are "
      "as wrong as it is.",
      w.subject(0), w.percent(F::kRelative, "{:.1f} %"), cause);
}

}  // namespace

std::string words_of_datum(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kNoDatum:
      return "Nothing fixes position, attitude and scale" +
             (w.finding.subjects.empty() ? "" : " of the part with " + w.subject(0)) + ": a free network.";
    case C::kDatumDefect:
      return datum_defect_words(w);
    case C::kLocalGauge:
      return "Positions and control do not fix where the block lies (fewer than three, or all on one line): local "
             "gauge.";
    case C::kPositionsOnLine:
      return "Positions of images lie on one line: the tilt across it is that of the attitudes the camera wrote, good "
             "to about a degree.";
    case C::kLevelByEdges:
      return level_words(w, LevelSource::kEdges);
    case C::kLevelByView:
      return level_words(w, LevelSource::kView);
    case C::kLevelByLowerEdges:
      return level_words(w, LevelSource::kLowerEdges);
    case C::kLevelByAttitudes:
      return level_words(w, LevelSource::kAttitudes);
    case C::kHeightsRelative:
      return "Heights are relative: zero is that of the middle camera, because no image has a height.";
    default:
      return "";
  }
}

std::string words_of_weak_images(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kScaleDrifts:
      return "No point is seen on both sides of " + w.all() +
             ": the models hang together in pairs, without triple overlap, and each has its own scale.";
    case C::kLooseImages:
      return "Images can move against the others without any measurement noticing, most of all " + w.all() + ".";
    case C::kNoBase:
      return "Images look from nearly one position: " + w.all() +
             ". They are rotated only, so that the distances of their points, and the scale of what hangs on them, are "
             "not determined.";
    case C::kImagesLeftOut:
      return "Images cannot be determined: " + w.all() + ". Fewer than three of their points are known elsewhere.";
    case C::kMismatchesLeft:
      return fmt::format(
          "{} of {} measurements of tie points ({:.1f} %) lie more than ten robust standard deviations off: they are "
          "of "
          "other points. They bend the block and enlarge sigma0.",
          w.whole(F::kCount), w.whole(F::kOf), 100 * w[F::kShare]);
    case C::kGeodeticLeftOut:
      return fmt::format(
          "{} of {} measurements on the ground {} no part: too few images show {} points, or these "
          "do not determine {} plane, line or height and one point more.",
          w.whole(F::kCount), w.whole(F::kOf), w.one() ? "takes" : "take", w.one() ? "its" : "their",
          w.one() ? "its" : "their");
    case C::kWeakImages:
      return fmt::format("Images are known more than five times worse than the others: {}, {:.2g} m against {:.2g} m.",
                         w.all(), w[F::kSigma], w[F::kTypicalSigma]);
    default:
      return "";
  }
}

std::string words_of_weak_unknowns(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kWeakRotation:
      return fmt::format(
          "The rotation of the block about {} is known to {:.2g} degrees only, {}: all that fixes it "
          "lies near that line.",
          axis_words(w), w[F::kSigmaAngle], motion_words(w));
    case C::kWeakScale:
      return fmt::format("The scale is known to {:.2g} only, {}.", w[F::kSigmaScale], motion_words(w));
    case C::kFocalAndHeight:
    case C::kCameraAndPose:
      return w.finding.subjects.empty() ? "" : mixture_words(w);
    case C::kParameterNotDetermined:
      return undetermined_parameters(w);
    case C::kInseparable:
      return fmt::format("Two unknowns can hardly be separated: {} (correlation {:.3f}).", w.all(),
                         std::trunc(1000 * w[F::kCorrelation]) / 1000);
    case C::kUndetermined:
      return "The observations do not determine " + w.subject(0) + ".";
    default:
      return "";
  }
}

std::string words_of_weak_cases(const FindingWords& w) {
  switch (w.finding.code) {
    case C::kFocalOfFlatScene:
      return focal_undetermined(w, "the scene is flat and seen from one direction");
    case C::kFocalAlongView:
      return focal_undetermined(w, "the camera moved along its view");
    case C::kFocalOfFewImages:
      return focal_undetermined(w, "the images are too few or too much alike");
    case C::kFocalMoved:
      return fmt::format(
          "The focal length of {} came out at {:.0f} px, {:+.0f} % from the {:.0f} px that were given: more than their "
          "source allows ({:.1f} of its standard deviations). The images may have been cropped or resampled, or the "
          "lens was another one.",
          w.subject(0), w[F::kFocal], 100 * w[F::kRelative], w[F::kFocalGiven], w[F::kRatio]);
    case C::kMovedAlongView:
      return "The camera moved along its view: rays meet at small angles, and distances ahead are weak, most of all in "
             "the middle of the images.";
    case C::kMovedWhileRead:
      return fmt::format(
          "The camera turned while images were read out line by line (rolling shutter): {} of the squared "
          "residuals of tie points go with the line, most in {}. The adjustment takes an image as taken "
          "at one instant, so the model is strained there.",
          w.percent(F::kShare, "{:.0f} %"), w.all());
    case C::kPairsContradict:
    case C::kPairsContradictWhileRead:
      return fmt::format(
          "{} of images {} but not with the block, most of all {} ({} matches): "
          "{}repeated structure (windows, rows of trees), or things that moved. Such matches were left "
          "out.",
          w.counted(F::kCount, "pair"), w.one() ? "agrees in itself" : "agree between themselves", w.all(),
          w.whole(F::kMatches), w.finding.code == C::kPairsContradictWhileRead ? "the rolling shutter, " : "");
    case C::kCriticalSurface:
      return "Tie points and projection centres lie on one curved surface (cylinder, cone, hyperboloid): a critical "
             "surface, on which other shapes explain the images as well.";
    default:
      return "";
  }
}

}  // namespace collinea
