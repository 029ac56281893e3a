// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/id.h"
#include "collinea/base/option_name.h"

namespace collinea {

/// A finding: one thing that is wrong, weak or noteworthy in what was given or in what came out of it, as a value that
/// any face can show, sort, count or act upon:
///
///     findings.push_back(finding_of(FindingCode::kControlPoint, {point}, {{FigureName::kOffset, off.norm()}}));
///
/// It holds no sentence. `report` makes sentences (finding_words.h) of code, figures and the names of its subjects,
/// which are looked up in the block. `fields` of these structs names their members, for whoever stores them.

/// How much a finding matters. Note: what was done or assumed. Weak: the result holds, but less than it could. Wrong:
/// something that was given contradicts the rest, or is not there.
enum class Severity : std::uint8_t { kNote, kWeak, kWrong };

/// What was found. Closed: each has one row in finding.cc (word, severity, figures) and one sentence in `report`.
enum class FindingCode : std::uint8_t {
  // Images and files as given
  kFocalAssumed,         ///< no focal length in the files of a camera
  kFocalImpossible,      ///< one that cannot be
  kHeightsCountFrom,     ///< what heights of positions count from
  kPositionsOfOthers,    ///< a file of positions names images that are not there
  kPositionsAmbiguous,   ///< the same; several images end in one number
  kPositionsNotStated,   ///< images that a file of positions does not name
  kTimesOfHeaders,       ///< times are those of the headers, because the file of positions states not all
  kControlOutsideImage,  ///< a measurement of control outside its image
  kControlImageMissing,  ///< control measured in an image that is not there
  kControlNotGiven,      ///< a file of control that lies beside the images and was not given
  kControlUnseen,        ///< a control point in no image
  kCheckSeenOnce,        ///< a check point in one image
  kControlSeenOnce,      ///< a control point in one image
  kImageUnreadable,      ///< a file that is no readable image
  kImageTooSmall,
  kImageDuplicate,     ///< the same bytes as another one
  kScanNotOriented,    ///< a scan of film whose marks were not found
  kScanMarksDisagree,  ///< a scan of film whose marks do not lie as the calibration has them
  kFolderUnreadable,   ///< a folder of images that cannot be looked into
  kCamerasMerged,      ///< an orientation gives one camera several interior orientations
  kOrientationTaken,   ///< poses come from elsewhere
  kOrientationFixed,   ///< the same, and are not adjusted
  // Control against images and positions
  kControlMeasurement,           ///< one image measurement does not meet the others; excluded
  kControlMeasurementsDisagree,  ///< rays of a point miss each other; the point is excluded
  kControlPoint,                 ///< the coordinates of a point contradict the other points; excluded
  kControlPointByPositions,      ///< the same, by the other points and the positions of images
  kCheckPoint,               ///< the coordinates of a check point contradict the control; it is compared all the same
  kControlInconsistent,      ///< two points contradict each other and nothing tells which is wrong
  kControlAxesSwapped,       ///< eastings and northings are exchanged
  kControlAxesExchanged,     ///< they were exchanged back
  kMarksCountedOtherwise,    ///< image measurements of control fit another system of image coordinates: the detail
  kMarksCorrected,           ///< they were brought into the images so
  kMarksOutside,             ///< many lie outside their images; kept, to find out how they were counted
  kMarksMirrored,            ///< images of a file of measurements fit mirrored ones better: the detail
  kPositionHeights,          ///< heights of positions are off those of control by a constant
  kPositionOffset,           ///< positions are off the control by a constant in plan
  kPositionCrs,              ///< by so much that one of the two is in another coordinate system
  kControlMeasurementSigma,  ///< image measurements of control are worse than stated
  kControlSigmaPlan,         ///< coordinates of control are worse than stated
  kControlSigmaHeight,
  kPositionsShifted,      ///< positions were shifted to the control
  kPositionOutweighs,     ///< one that contradicts the others and would outweigh them; excluded
  kDistancesContradict,   ///< two distances, and nothing tells which is wrong
  kDistanceWrong,         ///< a distance contradicts the others; excluded
  kGeodeticDiffers,       ///< a geodetic observation differs from the block beyond its sigma
  kGeodeticAngleDiffers,  ///< the same of an angle
  // Datum
  kNoDatum,            ///< nothing fixes position, attitude and scale
  kDatumDefect,        ///< nothing fixes some of them: the subjects
  kLocalGauge,         ///< positions and control do not fix the block
  kPositionsOnLine,    ///< the tilt across it is that of attitudes
  kLevelByEdges,       ///< positions do not tell the tilt: level by horizontal edges of images
  kLevelByView,        ///< by the mean view, taken as down
  kLevelByLowerEdges,  ///< by the mean lower edge of images as they are held
  kLevelByAttitudes,
  kHeightsRelative,  ///< no position has a height
  // What is determined badly
  kWeakRotation,  ///< a rotation of the block
  kWeakScale,
  kFocalAndHeight,          ///< parameters of a camera and the distance between images and object
  kCameraAndPose,           ///< parameters of a camera and another motion of the images
  kParameterNotDetermined,  ///< parameters of a camera that owe their values to their priors
  kScaleDrifts,             ///< images through which alone two parts hang together
  kLooseImages,             ///< images that can move against the others
  kNoBase,                  ///< images from nearly one position
  kImagesLeftOut,           ///< images with too few observations
  kMismatchesLeft,          ///< measurements of tie points that are of others take part
  kGeodeticLeftOut,         ///< geodetic observations whose points are not determined
  kWeakImages,              ///< images known far worse than the others
  kInseparable,             ///< two unknowns that hardly differ in their effect
  kUndetermined,            ///< an unknown that the observations do not determine: no standard deviations
  kFocalOfFlatScene,        ///< a focal length hardly determined, because the scene is flat and seen from one direction
  kFocalAlongView,          ///< because the camera moved along its view
  kFocalOfFewImages,        ///< because the images are few or alike
  kFocalMoved,              ///< a focal length that the images make another than its source allows
  kMovedAlongView,          ///< rays meet at small angles
  kMovedWhileRead,          ///< rolling shutter
  kPairsContradict,         ///< pairs that agree between themselves but not with the block
  kPairsContradictWhileRead,  ///< the same, where a rolling shutter may be the cause
  kCriticalSurface,           ///< points and centres on one quadric
  // What orientation did
  kFewFitGiven,             ///< few tie points fit poses as given
  kLooseGiven,              ///< images whose given pose hardly a tie point fits
  kAdditionalFixed,         ///< no additional parameters, because poses are fixed
  kAdditionalUncalibrated,  ///< none, because no camera is calibrated
  kAdditionalSignificant,   ///< how many of a camera's are
  kPositionsUnused,         ///< no lever arm, shift or time offset of positions that take no part
  kAttitudesUnused,         ///< attitudes of a block without position on Earth
  kShiftUnused,             ///< a shift of positions that no control parts from the block's position
  kInstrument,              ///< a lever arm, shift, drift, boresight or time offset as estimated
  kInstrumentsMore,         ///< those of further strips
  kSystematic,              ///< an error that many observations have in common, and what cannot be told from it
  kSystematicTakenUp,       ///< the same; the adjustment now estimates it
  kPositionsInOrder,        ///< residuals of positions follow each other, or take turns, in the order flown
  kImageResidualsAlike,     ///< residuals of neighbours in images, or means of images in the order flown, are alike
  kResidualDistribution,    ///< residuals have another distribution than that by which they are tested
  kGrossErrorRejected,      ///< a measurement of what was given that data snooping rejected
  kPartApart,               ///< images that hang together but not with the block
  kImagesAlone,             ///< images that could not be oriented
  // Products
  kNoDepthMap,    ///< of an image
  kNotDownwards,  ///< a product was skipped: images do not look down
  kNoScale,       ///< a product was skipped: the block has no scale
  kNoGround,      ///< a terrain model was skipped: nothing in the surface model is ground
  kNoPreview,     ///< of a product in the report
  // What an exchange format cannot hold
  kProjectionFitted,  ///< the projection of a camera is approximated by another one
  kShearDropped,
  kAdditionalDropped,
  kImagesNotExported,
  kDistortionFitted,  ///< image coordinates were corrected for what a format's camera cannot hold
  // A pair of images
  kPairFewPoints,      ///< for its relative orientation
  kPairZonesEmpty,     ///< parts of the overlap without points
  kPairParallax,       ///< y-parallaxes beyond what matching leaves
  kPairGeometry,       ///< near to one that leaves the orientation open; the detail is the word of a PairWeakness
  kPairBase,           ///< too short for the heights that are wanted
  kPairControlApart,   ///< parts of the overlap without control
  kPairLevelsDropped,  ///< levels of the surface had too few points to take the place of the one before
  kPairCellsMeasured,  ///< few of the cells of the surface model
  // Control and models
  kControlContradicts,  ///< a coordinate of control against the others; it takes part all the same
  kResidualsLarge,      ///< than the stated standard deviations allow
  kResidualsSmall,      ///< ... let expect
  kModelNoPoint,        ///< a model that is left out: it shares no point
  kModelTurns,          ///< ... it shares one or two points, about which it can turn
  kModelNotFixed,       ///< ... it shares points on a line, or in plan or height alone
  kModelNoControl,      ///< ... it hangs together with others but not with the block
  kModelFewPoints,      ///< a model that is joined by few points
  kModelPointsOnLine,   ///< a model that is joined by points near a line
  kModelUnchecked,      ///< a model that nothing checks
  kPairMakesNoModel,    ///< the detail is why
  // Single steps of orientation: points, marks and images by their names
  kNothingChecks,           ///< as many measurements as unknowns
  kMeasurementContradicts,  ///< one of a point (in an image) against the others; it takes part all the same
  kMeasurementsRejected,    ///< contradict the others and take no part
  kFewPoints,               ///< of an orientation
  kSolutionsOpen,           ///< several orientations fit as well
  kSolutionChosen,          ///< of several that fit as well, by what is known otherwise
  kPointsBehind,            ///< rays meet behind an image
  kPoseWeak,                ///< control that hardly determines the pose of an image
  kDangerCircle,            ///< control on a circle, and the station near it or near the cylinder over it
  kPoseOpen,                ///< no pose follows from a projection matrix alone
  kSeenOnce,                ///< points in one oriented image
  kRaysWithoutPoint,        ///< rays that are parallel or meet behind an image
  kRaysNarrow,              ///< rays that meet at small angles
  kRaysMiss,                ///< two rays that do not meet, and nothing tells which is wrong
  kOrientationsExact,       ///< no standard deviations of the orientations that points are intersected with
  kCombinationsOpen,        ///< of two pairs: not one and its mirror image
  kControlFew,              ///< for an absolute orientation
  kControlOnLine,           ///< nearly
  kControlRejected,         ///< contradicts the others and takes no part
  kRankNearThree,           ///< projective cameras that are hardly determined: points near a plane
  kNotInAllImages,          ///< points that not all images show
  kOneCalibrationRefuted,   ///< of all images
  kStatedCameraRefuted,     ///< by self-calibration
  kNoEuclideanForm,         ///< the detail is why
  kCameraFitsNot,           ///< no orientation with the stated camera: the detail is why
  kPrincipalDistanceWeak,   ///< of a self-calibration
  kFiducialsContradict,     ///< marks of a film against each other beyond what film and readings do
  kFiducialsLeftOut,        ///< misread
  kFiducialsMissing,        ///< not measured, or not found
  kFiducialsUnknown,        ///< measured, and not in the calibration
  kReadingsContested,       ///< of a mark, none of which is outvoted
  kReadingsGross,           ///< left out
  kSeenFromBehind,          ///< a scan of a film from its back
  // Edits by hand
  kEditUnfit,  ///< an edit of a point (and in an image) that does not fit what was imported; the detail: it, and why
};
inline constexpr std::size_t kFindingCodes = static_cast<std::size_t>(FindingCode::kEditUnfit) + 1;

/// What a figure is. Its unit belongs to it; both are in the word: "offset_m".
enum class FigureName : std::uint8_t {
  kOffset,        ///< how far off [m]
  kOffsetPlan,    ///< the same in plan [m]
  kOffsetHeight,  ///< ... in height, with sign [m]
  kEast,          ///< of an offset or a shift [m]
  kNorth,
  kUp,
  kOffsetPx,  ///< how far off [px]
  kPixelX,    ///< a position in an image [px]
  kPixelY,
  kLine,     ///< of a text file, from 1
  kCount,    ///< how many [1]
  kOf,       ///< of how many [1]
  kCameras,  ///< how many of them [1]
  kHeights,  ///< how many positions with a height [1]
  kMatches,  ///< of a pair [1]
  kLimit,    ///< fewer than so many, more than so many [1]
  kWidth,    ///< of images [px]
  kHeight,
  kFocal,  ///< [px]
  kFocalLowest,
  kFocalHighest,
  kLowest,  ///< of heights [m]
  kHighest,
  kCorrelation,  ///< [1]; several: of the subjects after the first, in their order; with none: the strongest
  kRatio,        ///< times what is expected, stated or usual [1]
  kSigma,        ///< [m]
  kSigmaPx,
  kSigmaAngle,       ///< [deg]
  kSigmaAzimuth,     ///< [deg]
  kSigmaScale,       ///< relative [1]
  kTypicalSigma,     ///< that of the others [m]
  kReference,        ///< of what fixes it [m]
  kExtent,           ///< size of the block [m]
  kMotion,           ///< what it shifts at the block's edge [m]
  kAzimuth,          ///< of an axis [deg]
  kSteepness,        ///< of an axis: 0 level, 1 upright [1]
  kDefect,           ///< degrees of freedom [1]
  kShare,            ///< [1]
  kRelative,         ///< a relative error [1]
  kDifference,       ///< [m]
  kDifferenceAngle,  ///< [deg]
  kValue,            ///< of an estimated unknown, in the unit of its kind; several: of its axes
  kValueSigma,
  kChance,      ///< of something as large by accident [1]
  kFocalGiven,  ///< before any adjustment [px]
  kTest,        ///< standardised residual w [1]
  kWanted,      ///< a standard deviation that is wanted [m]
  kAngle,       ///< [deg]
  kRadius,      ///< [m]
};
inline constexpr std::size_t kFigureNames = static_cast<std::size_t>(FigureName::kRadius) + 1;

/// A number of a finding.
struct Figure {
  FigureName name{};
  double value = 0;

  friend bool operator==(const Figure&, const Figure&) = default;

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = Figure;
    visit("name", &R::name);
    visit("value", &R::value);
  }
};

/// What kind of thing a subject is.
enum class SubjectKind : std::uint8_t {
  kBlock,  ///< as a whole
  kImage,
  kCamera,
  kTiePoint,
  kControlPoint,  ///< or check point
  kGeodetic,      ///< a geodetic observation: index in Block::geodetic
  kStrip,         ///< of image positions, from 0
  kSetup,         ///< of an instrument on the ground, from 0
  kLevel,         ///< a height that points have in common: number of the shape
  kPlane,
  kLine,
  kFile,     ///< by name, relative or as given
  kCrs,      ///< by name
  kProduct,  ///< id: of Product
  kModel,    ///< an independent model, by name
  kPoint,    ///< a measured point that is in no block, by name
  kMark,     ///< a fiducial mark, by name
};

inline constexpr std::size_t kSubjectKinds = static_cast<std::size_t>(SubjectKind::kMark) + 1;

/// Products of steps.
enum class Product : std::uint8_t { kSurfaceModel, kTerrainModel, kOrthophoto };

/// What of the subject is meant.
enum class Aspect : std::uint8_t {
  kWhole,     ///< itself
  kPosition,  ///< [m]; of a plane or a line: across it
  kAttitude,
  kParameter,    ///< of a camera; axis: Camera::Param
  kOrientation,  ///< of a set-up
  kLeverArm,     ///< axis: to the right, downwards, along the optical axis
  kShift,        ///< of positions; axis: east, north, height
  kDrift,        ///< the same in time
  kBoresight,    ///< axis: about x, y, the optical axis
  kTimeOffset,   ///< of positions
  kHeight,
  kTilt,       ///< of a plane, of the block
  kDirection,  ///< of a line
  kScale,
  kPlan,      ///< position in plan
  kRotation,  ///< about one axis (kAzimuth, kSteepness) or, where two control points are named, the line through them
  kTwoRotations,  ///< two of three
  kSomeShift,     ///< a direction that is neither plan nor height
  kDistance,      ///< of images from the object
  kTiltX,         ///< of images about their x axis
  kTiltY,
  kPositionX,  ///< of images along their x axis
  kPositionY,
  kVerticalDatum,  ///< of positions against control
  kAssignment,     ///< of positions to images; axis: 0 they are of the next image, 1 of the previous one
  kBowl,           ///< of heights
  kAffinity,       ///< of the columns of a camera
  kAdditional,     ///< parameters of a camera; axis: AdditionalSet
  kRollingShutter,
  kRefraction,
};

inline constexpr std::size_t kAspectsOfSubjects = static_cast<std::size_t>(Aspect::kRefraction) + 1;

/// What a finding is about: a thing of the block by its id, or a thing that has no id by its name.
struct Subject {
  static constexpr std::uint32_t kAll = ~std::uint32_t{0};  ///< every one of its kind
  static constexpr std::uint8_t kAlongFlight = 3;           ///< an axis that is none of the three

  SubjectKind kind = SubjectKind::kBlock;
  std::uint32_t id = kAll;
  Aspect aspect = Aspect::kWhole;
  std::uint8_t axis = 0;
  std::string name;  ///< of files, coordinate reference systems, and of models and points that are in no block

  Subject() = default;
  Subject(SubjectKind of, std::uint32_t number, Aspect what = Aspect::kWhole, int along = 0)
      : kind(of), id(number), aspect(what), axis(static_cast<std::uint8_t>(along)) {}
  Subject(ImageId image, Aspect what = Aspect::kWhole) : Subject(SubjectKind::kImage, image.value, what) {}
  Subject(CameraId camera, Aspect what = Aspect::kWhole, int along = 0)
      : Subject(SubjectKind::kCamera, camera.value, what, along) {}
  Subject(PointId point) : Subject(SubjectKind::kTiePoint, point.value) {}
  Subject(ControlId point, Aspect what = Aspect::kWhole) : Subject(SubjectKind::kControlPoint, point.value, what) {}
  Subject(Product product) : Subject(SubjectKind::kProduct, static_cast<std::uint32_t>(product)) {}
  /// A subject that is an aspect of the block as a whole.
  explicit Subject(Aspect what) : Subject(SubjectKind::kBlock, kAll, what) {}

  [[nodiscard]] static Subject geodetic(std::size_t index);  ///< in Block::geodetic
  [[nodiscard]] static Subject file(std::string name);
  [[nodiscard]] static Subject crs(std::string name);
  [[nodiscard]] static Subject model(std::string name);
  [[nodiscard]] static Subject control_named(std::string name);  ///< a point that is in no block
  [[nodiscard]] static Subject point(std::string name);
  [[nodiscard]] static Subject mark(std::string name);
  [[nodiscard]] static Subject image_named(std::string name);  ///< an image that is in no block

  /// The id, where the subject is of that kind.
  [[nodiscard]] std::optional<ImageId> image() const;
  [[nodiscard]] std::optional<CameraId> camera() const;
  [[nodiscard]] std::optional<ControlId> control() const;

  friend auto operator<=>(const Subject&, const Subject&) = default;

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = Subject;
    visit("kind", &R::kind);
    visit("id", &R::id);
    visit("aspect", &R::aspect);
    visit("axis", &R::axis);
    visit("name", &R::name);
  }
};

/// What to do. One phrase each in `report`.
enum class RemedyCode : std::uint8_t {
  kSetOption,  ///< Remedy::option
  kFixDatum,   ///< control, positions or a distance
  kGiveScale,
  kGiveControlForAttitude,
  kGiveHeightsForTilt,
  kGiveControlOffLine,
  kGiveControlOffThatLine,
  kGivePosition,
  kGiveHeight,
  kGivePlan,
  kGiveMoreCoordinates,
  kMeasureTiePoints,  ///< in images that have too few
  kMeasureTiePointsBetween,
  kSpreadTiePoints,
  kMeasureGroundPoints,  ///< in two images and more; name more points on shapes
  kAddImagesFromElsewhere,
  kAddTripleOverlap,
  kWidenControl,
  kWidenControlInPlan,
  kAddCrossStrip,  ///< or control off the line, or attitudes
  kVaryHeights,    ///< of images, control or relief
  kRotateImages,   ///< by 90 and 180 degrees
  kReachCorners,   ///< points out to the corners of images
  kFewerParameters,
  kCalibrateCamera,
  kFlyBack,  ///< strips in the opposite direction under one shift
  kSpreadShapePoints,
  kAddHeightsOrOblique,
  kMeasureMoreFromSetup,
  kFlyBackAndAcross,
  kAddCrossStripOrControl,
  kGiveOne,       ///< of two unknowns that cannot be separated
  kAddDistances,  ///< images from other distances, turned, oblique; control at different heights
  kAddSideViews,
  kHoldStill,      ///< or use a global shutter
  kRemoveRepeats,  ///< images of repeated structure, or add some that show the positions apart
  kLeaveSurface,
  kGiveThreeControlPoints,
  kAddStripOrControl,
  kLookForMarks,   ///< that do not show the same position in all images
  kLookForPoints,  ///< that are wrong, or state the sigma they have
  kLookAtDistance,
  kAddDistance,       ///< a third one
  kMeasureInAnother,  ///< image
  kFolderOfEachFlight,
  kSeeAdjustment,     ///< which tells more
  kCorrectMarks,      ///< image coordinates, in the file that they come from
  kLookForNames,      ///< of images in the file of positions
  kLookForDatum,      ///< what heights count from
  kSpreadPairPoints,  ///< over all parts of the overlap
  kGiveControlInCorners,
  kLengthenBase,
  kShareModelPoints,    ///< more, off one line, with the neighbouring models
  kStateSigmas,         ///< that the measurements have
  kMeasureMorePoints,   ///< well spread
  kMeasureAgain,        ///< or leave it out
  kSpreadControl,       ///< over the image and in height
  kLeaveCircle,         ///< by a point off it
  kGiveFourthPoint,     ///< or an approximate position
  kGiveHeightMore,      ///< of a further point
  kGiveControlAtEdges,  ///< four full points and a height
  kCheckAssignment,     ///< of left and right, and how y is counted
  kStateOrientationSigmas,
  kMeasureInMoreImages,
  kTakeWiderBase,  ///< images from farther apart
  kGivePrincipalDistance,
  kReadMarksAgain,
  kCompareMarkNames,  ///< readings and calibration
};
inline constexpr std::size_t kRemedyCodes = static_cast<std::size_t>(RemedyCode::kCompareMarkNames) + 1;

/// One thing that helps. Several of a finding are alternatives, except for kDatumDefect: there each helps one subject.
struct Remedy {
  RemedyCode code{};
  OptionName option;  ///< of kSetOption

  Remedy() = default;
  Remedy(RemedyCode what) : code(what) {}
  Remedy(OptionName set) : code(RemedyCode::kSetOption), option(std::move(set)) {}

  friend bool operator==(const Remedy&, const Remedy&) = default;

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = Remedy;
    visit("code", &R::code);
    visit("option", &R::option);
  }
};

struct Finding {
  FindingCode code{};
  Severity severity = Severity::kNote;
  std::vector<Subject> subjects;
  std::vector<Figure> figures;
  std::vector<Remedy> remedies;
  std::string detail;  ///< verbatim words of others: the message of an error, a name that has no id; mostly empty

  /// The first figure of that name; nothing when there is none.
  [[nodiscard]] std::optional<double> figure(FigureName name) const;
  /// All of that name, in their order.
  [[nodiscard]] std::vector<double> figures_of(FigureName name) const;

  friend bool operator==(const Finding&, const Finding&) = default;

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = Finding;
    visit("code", &R::code);
    visit("severity", &R::severity);
    visit("subjects", &R::subjects);
    visit("figures", &R::figures);
    visit("remedies", &R::remedies);
    visit("detail", &R::detail);
  }
};

/// A finding with the severity of its code.
[[nodiscard]] Finding finding_of(FindingCode code, std::vector<Subject> subjects = {}, std::vector<Figure> figures = {},
                                 std::vector<Remedy> remedies = {}, std::string detail = {});

[[nodiscard]] std::string_view word_of(FindingCode code);   ///< "control_point"
[[nodiscard]] std::string_view word_of(Severity severity);  ///< "note", "weak", "wrong"
[[nodiscard]] std::string_view word_of(FigureName name);    ///< "offset_m"
[[nodiscard]] std::string_view unit_of(FigureName name);    ///< "m"; "1" without unit
[[nodiscard]] std::string_view word_of(SubjectKind kind);   ///< "control_point"
[[nodiscard]] std::string_view word_of(Product product);    ///< "surface_model"
[[nodiscard]] std::string_view word_of(Aspect aspect);      ///< "lever_arm"
[[nodiscard]] std::string_view word_of(RemedyCode code);    ///< "give_scale"
[[nodiscard]] Severity severity_of(FindingCode code);       ///< that it has, unless a finding says otherwise
[[nodiscard]] std::span<const FigureName> figures_of(FindingCode code);  ///< that come with it
[[nodiscard]] std::optional<FindingCode> finding_code_named(std::string_view word);

}  // namespace collinea
