// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/finding_words.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "collinea/quality/mark_systems.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/systematic_words.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;

// A finding with what its words are made of.
struct Words {
  const Finding& finding;
  const Block& block;

  [[nodiscard]] double operator[](F name) const {
    return finding.figure(name).value_or(std::numeric_limits<double>::quiet_NaN());
  }
  [[nodiscard]] std::string whole(F name) const { return fmt::format("{:.0f}", (*this)[name]); }
  [[nodiscard]] std::string percent(F name, const char* format = "{:.2g} %") const {
    return fmt::format(fmt::runtime(format), 100 * (*this)[name]);
  }
  [[nodiscard]] std::string all() const { return words_of(finding.subjects, block); }
  [[nodiscard]] std::string subject(std::size_t i) const {
    return i < finding.subjects.size() ? words_of(finding.subjects[i], block) : "";
  }
  /// Subjects from the i-th on.
  [[nodiscard]] std::string from(std::size_t i) const {
    if (i >= finding.subjects.size()) return "";
    return words_of(
        std::vector<Subject>(finding.subjects.begin() + static_cast<std::ptrdiff_t>(i), finding.subjects.end()), block);
  }
  [[nodiscard]] bool one() const { return (*this)[F::kCount] == 1; }
  /// The first of those that are counted, or the only one: ", the first: X" or ": X".
  [[nodiscard]] std::string first(std::size_t i) const { return (one() ? ": " : ", the first: ") + subject(i); }
  /// "1 image", "3 images".
  [[nodiscard]] std::string counted(F name, const char* what) const {
    return whole(name) + " " + what + ((*this)[name] == 1 ? "" : "s");
  }
};

// --- images and files as given

std::string focal_words(const Words& w) {
  return fmt::format(
      "{} ({} x {} px) has {} focal length in its files. {} px are assumed, to be found by self-calibration.",
      w.subject(0), w.whole(F::kWidth), w.whole(F::kHeight),
      w.finding.code == C::kFocalAssumed ? "no" : "an impossible", w.whole(F::kFocal));
}

std::string orientation_words(const Words& w) {
  return fmt::format("{} of {} of {} images {} taken from {}, and {}.",
                     w[F::kCameras] > 0 ? "Orientation and camera" : "Orientation", w.whole(F::kCount), w.whole(F::kOf),
                     w[F::kCameras] > 0 ? "are" : "is", w.subject(0),
                     w.finding.code == C::kOrientationFixed ? "fixed as given" : "adjusted");
}

std::string words_of_given(const Words& w) {
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
      return "Image " + w.subject(0) + " is skipped: " + reason_of(w.finding, w.block) + ".";
    case C::kFolderUnreadable:
      return "Folder " + w.subject(0) + " is skipped: " + reason_of(w.finding, w.block) + ".";
    default:
      return "";
  }
}

// --- control

std::string wrong_point(const Words& w, const char* judge) {
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

std::string words_of_marks(const Words& w) {
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

std::string words_of_measured_control(const Words& w) {
  switch (w.finding.code) {
    case C::kControlOutsideImage:
      return fmt::format("Control {} in {} (line {}): pixel {:.1f}, {:.1f} lies outside the image. It is left out.",
                         w.subject(0), w.subject(1), w.whole(F::kLine), w[F::kPixelX], w[F::kPixelY]);
    case C::kControlImageMissing:
      return fmt::format("Control file: no image is called {} ({} left out).", w.subject(0),
                         w.counted(F::kCount, "measurement"));
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

std::string words_of_control(const Words& w) {
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

std::string words_of_positions(const Words& w) {
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

// --- datum

std::string axis_words(const Words& w) {
  if (w[F::kSteepness] > 0.9) return "the vertical";
  return fmt::format("a{} axis with the azimuth {:.0f} degrees", w[F::kSteepness] < 0.3 ? " level" : "n inclined",
                     w[F::kAzimuth]);
}

std::string datum_defect_words(const Words& w) {
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

std::string level_words(const Words& w, LevelSource by) {
  return fmt::format(
      "Positions of images {}: what is level comes from {}, good to about {:.0f} degrees. The scale is "
      "good to {}, north to {:.2g} degrees.",
      w[F::kHeights] > 0 ? "reach too little for their errors to tell how the block is tilted" : "have no heights",
      words_of(by), std::max(1.0, w[F::kSigmaAngle]), w.percent(F::kSigmaScale), w[F::kSigmaAzimuth]);
}

std::string words_of_datum(const Words& w) {
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

// --- what is determined badly

std::string motion_words(const Words& w) {
  return fmt::format(
      "which shifts what lies {:.3g} m from the middle by {:.2g} m, while what fixes it is known to "
      "{:.2g} m",
      w[F::kExtent], w[F::kMotion], w[F::kReference]);
}

// The first subject is a motion of images; the others are parameters, each with its correlation.
std::string mixture_words(const Words& w) {
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

std::string undetermined_parameters(const Words& w) {
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

std::string words_of_weak_images(const Words& w) {
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

std::string words_of_weak_unknowns(const Words& w) {
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

std::string focal_undetermined(const Words& w, const char* cause) {
  return fmt::format(
      "The focal length of {} is hardly determined by the images ({}): {}. Distances across the view are "
      "as wrong as it is.",
      w.subject(0), w.percent(F::kRelative, "{:.1f} %"), cause);
}

std::string words_of_weak_cases(const Words& w) {
  switch (w.finding.code) {
    case C::kFocalOfFlatScene:
      return focal_undetermined(w, "the scene is flat and seen from one direction");
    case C::kFocalAlongView:
      return focal_undetermined(w, "the camera moved along its view");
    case C::kFocalOfFewImages:
      return focal_undetermined(w, "the images are too few or too much alike");
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

// --- what orientation did

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

std::string instrument_words(const Words& w) {
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
std::string gross_error_words(const Words& w) {
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

std::string words_of_orientation(const Words& w) {
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

// --- products and exchange

std::string words_of_products(const Words& w) {
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

}  // namespace

std::string reason_of(const Finding& skipped, const Block& block) {
  const Words words{skipped, block};
  switch (skipped.code) {
    case C::kImageTooSmall:
      return fmt::format("smaller than {} x {} pixels", words.whole(F::kLimit), words.whole(F::kLimit));
    case C::kImageDuplicate:
      return "the same bytes as " + words.subject(1);
    case C::kFolderUnreadable:
      return "cannot be read: " + skipped.detail;
    case C::kNoDepthMap:
      return "no depth map: " + skipped.detail;
    default:
      return skipped.detail;
  }
}

std::string what_of(const Finding& finding, const Block& block) {
  const Words words{finding, block};
  for (const auto of :
       {words_of_given, words_of_measured_control, words_of_marks, words_of_control, words_of_positions, words_of_datum,
        words_of_weak_images, words_of_weak_unknowns, words_of_weak_cases, words_of_orientation, words_of_products})
    if (std::string text = of(words); !text.empty()) return text;
  return std::string(word_of(finding.code)) + ".";
}

}  // namespace collinea
