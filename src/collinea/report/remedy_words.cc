// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string_view>

#include "collinea/base/words.h"
#include "collinea/report/finding_words.h"

namespace collinea {
namespace {

struct Phrase {
  RemedyCode code;
  std::string_view words;
};

using R = RemedyCode;
constexpr Phrase kPhrases[] = {
    {R::kSetOption, ""},
    {R::kFixDatum,
     "give three control points off one line, positions of three images off one line, or (for the scale alone) a known "
     "distance"},
    {R::kGiveScale, "give a known distance, a second control point or positions of images for the scale"},
    {R::kGiveControlForAttitude, "give two more control points, off one line, for the attitude"},
    {R::kGiveHeightsForTilt,
     "give heights of three control points off one line, or positions with heights, for the tilt"},
    {R::kGiveControlOffLine, "give control points off one line for the attitude"},
    {R::kGiveControlOffThatLine, "give a control point, or positions of images, off that line"},
    {R::kGivePosition, "give coordinates of control or positions of images"},
    {R::kGiveHeight, "give the height of a control point, or positions with heights"},
    {R::kGivePlan, "give eastings and northings of control, or positions of images"},
    {R::kGiveMoreCoordinates, "give more coordinates of control"},
    {R::kMeasureTiePoints, "measure more tie points that they share with other images, or control in them"},
    {R::kMeasureTiePointsBetween,
     "measure more tie points, well spread, between these images and the others, or control in them"},
    {R::kSpreadTiePoints, "measure more tie points, well spread over them, that other images see too"},
    {R::kMeasureGroundPoints,
     "measure their points in two images and more; name a point more on each line (three) and plane (four, not on a "
     "line)"},
    {R::kAddImagesFromElsewhere,
     "add images of the same things from other positions, at a tenth of the distance and more apart, or leave these "
     "out"},
    {R::kAddTripleOverlap,
     "see to points in three images and more (an overlap of 60 %), or to control or positions in every pair"},
    {R::kWidenControl, "give a longer known distance, control farther apart, or positions of images"},
    {R::kWidenControlInPlan, "give control or positions farther apart in plan"},
    {R::kAddCrossStrip, "add control off that line, a parallel or cross strip, or attitudes of the images"},
    {R::kVaryHeights, "add images at different heights or oblique ones, or control or relief at different heights"},
    {R::kRotateImages, "add strips flown across or back (images turned by 90 and 180 degrees), or relief"},
    {R::kReachCorners, "measure points out to the corners of the images"},
    {R::kFewerParameters, "use fewer parameters"},
    {R::kCalibrateCamera, "give a calibrated camera"},
    {R::kFlyBack, "fly strips in the opposite direction under one shift"},
    {R::kSpreadShapePoints, "give control, or points that are further apart"},
    {R::kAddHeightsOrOblique, "add strips at another height or oblique images"},
    {R::kMeasureMoreFromSetup, "measure to more points from there"},
    {R::kFlyBackAndAcross, "add strips in the opposite direction and across"},
    {R::kAddCrossStripOrControl, "add cross strips, or control in every strip"},
    {R::kGiveOne, "give one of them"},
    {R::kAddDistances,
     "add images from other distances or turned by 90 degrees and oblique ones, or use control points at different "
     "heights"},
    {R::kAddSideViews, "add images from the side, or looking sideways"},
    {R::kHoldStill, "hold the camera still for each image, or use one with a global shutter"},
    {R::kRemoveRepeats,
     "should the model be folded or doubled, remove these images, or add some that tell the locations apart"},
    {R::kLeaveSurface, "add images from off that surface, or control"},
    {R::kGiveThreeControlPoints, "give three control points"},
    {R::kAddStripOrControl, "add a second strip or three control points"},
    {R::kLookForMarks, "look for marks that do not show the same point in all images"},
    {R::kLookForPoints, "look for wrong points, or state the sigma they really have"},
    {R::kLookAtDistance, "look at its length and at the marks in the images"},
    {R::kAddDistance, "measure a third distance"},
    {R::kMeasureInAnother, "measure it in another image"},
    {R::kFolderOfEachFlight,
     "keep the images of each flight in a folder that is called like the beginning of the file's name"},
    {R::kSeeAdjustment, "see the report of an adjustment for which, and how alike they are"},
    {R::kCorrectMarks,
     "write columns to the right and rows downwards, in pixels from the upper-left corner of the images that are used, "
     "into the file of measurements"},
    {R::kLookForNames, "look whether names of images and their positions belong together"},
    {R::kLookForDatum, "look what the heights of positions and of control count from"},
    {R::kSpreadPairPoints, "find points in all parts of the overlap: with a lower threshold, or evenly spread"},
    {R::kGiveControlInCorners, "give control in all four corners of the overlap"},
    {R::kLengthenBase, "take photographs farther apart, or nearer to the object"},
    {R::kShareModelPoints, "measure more points, off one line, that it shares with the models beside it"},
    {R::kStateSigmas, "state the standard deviations that the measurements have"},
    {R::kMeasureMorePoints, "measure more points, spread over the images"},
    {R::kMeasureAgain, "measure it again, look at its coordinates and its name, or leave it out"},
    {R::kSpreadControl, "spread the control over the image and in height"},
    {R::kLeaveCircle, "use a point off the circle"},
    {R::kGiveFourthPoint, "give a fourth point, or an approximate position"},
    {R::kGiveHeightMore, "give the height of a further point"},
    {R::kGiveControlAtEdges, "give four points known in X, Y and Z near the corners, and a height in the middle"},
    {R::kCheckAssignment,
     "see that left and right are not exchanged, that y is counted the right way, and that the points are those of "
     "views of one object"},
    {R::kStateOrientationSigmas, "give the orientations with columns of their standard deviations"},
    {R::kMeasureInMoreImages, "measure them in a further oriented image"},
    {R::kTakeWiderBase, "use images from positions farther apart"},
    {R::kGivePrincipalDistance, "give the principal distance"},
    {R::kReadMarksAgain, "read it a third time"},
    {R::kCompareMarkNames, "compare the names of the marks, the readings and the calibration"},
};
static_assert(is_in_order(kPhrases, kRemedyCodes, &Phrase::code));

std::string spelled(const OptionName& option) {
  return "option " + option.name + (option.value.empty() ? "" : " = " + option.value);
}

std::string phrase_of(const Remedy& remedy, const SpellOption& spell) {
  if (remedy.code != RemedyCode::kSetOption)
    return std::string(kPhrases[std::min(static_cast<std::size_t>(remedy.code), kRemedyCodes - 1)].words);
  return (remedy.option.value.empty() ? "see " : "set ") + (spell ? spell(remedy.option) : spelled(remedy.option));
}

}  // namespace

std::string remedy_of(const Finding& finding, const SpellOption& spell) {
  if (finding.remedies.empty()) return "";
  // Remedies of a defect of the datum help one thing each, and all are needed.
  const char* last = finding.code == FindingCode::kDatumDefect ? " and " : ", or ";
  std::string text;
  for (std::size_t i = 0; i < finding.remedies.size(); ++i)
    text += (i == 0 ? "" : i + 1 == finding.remedies.size() ? last : ", ") + phrase_of(finding.remedies[i], spell);
  text.front() =
      static_cast<char>(text.front() >= 'a' && text.front() <= 'z' ? text.front() - 'a' + 'A' : text.front());
  return text + ".";
}

std::string sentence_of(const Finding& finding, const Block& block, const SpellOption& spell) {
  const std::string remedy = remedy_of(finding, spell);
  return what_of(finding, block) + (remedy.empty() ? "" : " " + remedy);
}

}  // namespace collinea
