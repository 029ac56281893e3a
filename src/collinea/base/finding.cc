// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/finding.h"

#include <algorithm>
#include <array>

#include "collinea/base/words.h"

namespace collinea {
namespace {

using C = FindingCode;
using F = FigureName;
constexpr Severity kNote = Severity::kNote, kWeak = Severity::kWeak, kWrong = Severity::kWrong;

struct CodeRow {
  C code;
  std::string_view word;
  Severity severity;
  std::array<F, 8> figures{};
  std::size_t figure_count = 0;

  template <class... Figures>
  constexpr CodeRow(C of, std::string_view called, Severity how, Figures... with)
      : code(of), word(called), severity(how), figures{with...}, figure_count(sizeof...(with)) {}
};

constexpr CodeRow kCodes[] = {
    {C::kFocalAssumed, "focal_assumed", kNote, F::kWidth, F::kHeight, F::kFocal},
    {C::kFocalImpossible, "focal_impossible", kNote, F::kWidth, F::kHeight, F::kFocal},
    {C::kHeightsCountFrom, "heights_count_from", kNote, F::kLowest, F::kHighest},
    {C::kPositionsOfOthers, "positions_of_others", kNote, F::kCount, F::kOf},
    {C::kPositionsAmbiguous, "positions_ambiguous", kNote, F::kCount, F::kOf},
    {C::kPositionsNotStated, "positions_not_stated", kNote, F::kCount, F::kOf},
    {C::kTimesOfHeaders, "times_of_headers", kNote},
    {C::kControlOutsideImage, "control_outside_image", kWrong, F::kPixelX, F::kPixelY, F::kLine},
    {C::kControlImageMissing, "control_image_missing", kWrong, F::kCount},
    {C::kControlNotGiven, "control_not_given", kNote},
    {C::kControlUnseen, "control_unseen", kWeak},
    {C::kCheckSeenOnce, "check_seen_once", kWeak},
    {C::kControlSeenOnce, "control_seen_once", kWeak},
    {C::kImageUnreadable, "image_unreadable", kNote},
    {C::kImageTooSmall, "image_too_small", kNote, F::kLimit},
    {C::kImageDuplicate, "image_duplicate", kNote},
    {C::kScanNotOriented, "scan_not_oriented", kWrong},
    {C::kScanMarksDisagree, "scan_marks_disagree", kWeak, F::kOffsetPx, F::kCount, F::kOf},
    {C::kFolderUnreadable, "folder_unreadable", kNote},
    {C::kCamerasMerged, "cameras_merged", kWeak, F::kFocalLowest, F::kFocalHighest},
    {C::kOrientationTaken, "orientation_taken", kNote, F::kCount, F::kOf, F::kCameras},
    {C::kOrientationFixed, "orientation_fixed", kNote, F::kCount, F::kOf, F::kCameras},
    {C::kControlMeasurement, "control_measurement", kWrong, F::kOffsetPx},
    {C::kControlMeasurementsDisagree, "control_measurements_disagree", kWrong, F::kOffsetPx, F::kCount},
    {C::kControlPoint, "control_point", kWrong, F::kOffset, F::kOffsetPlan, F::kOffsetHeight},
    {C::kControlPointByPositions, "control_point_by_positions", kWrong, F::kOffset, F::kOffsetPlan, F::kOffsetHeight},
    {C::kCheckPoint, "check_point", kWrong, F::kOffset},
    {C::kControlInconsistent, "control_inconsistent", kWrong, F::kOffset},
    {C::kControlAxesSwapped, "control_axes_swapped", kWrong},
    {C::kControlAxesExchanged, "control_axes_exchanged", kNote},
    {C::kMarksCountedOtherwise, "marks_counted_otherwise", kWrong, F::kCount, F::kOf, F::kCount, F::kOffsetPx,
     F::kRatio, F::kSigmaScale},
    {C::kMarksCorrected, "marks_corrected", kNote, F::kCount, F::kOf, F::kCount, F::kOffsetPx, F::kRatio,
     F::kSigmaScale},
    {C::kMarksOutside, "marks_outside", kWrong, F::kCount, F::kOf},
    {C::kMarksMirrored, "marks_mirrored", kWrong, F::kCount, F::kOf, F::kOffsetPx, F::kRatio},
    {C::kPositionHeights, "position_heights", kWrong, F::kUp},
    {C::kPositionOffset, "position_offset", kWrong, F::kOffset, F::kEast, F::kNorth},
    {C::kPositionCrs, "position_crs", kWrong, F::kOffset},
    {C::kControlMeasurementSigma, "control_measurement_sigma", kWeak, F::kRatio, F::kSigmaPx},
    {C::kControlSigmaPlan, "control_sigma_plan", kWeak, F::kRatio, F::kSigma},
    {C::kControlSigmaHeight, "control_sigma_height", kWeak, F::kRatio, F::kSigma},
    {C::kPositionsShifted, "positions_shifted", kNote, F::kEast, F::kNorth, F::kUp},
    {C::kPositionOutweighs, "position_outweighs", kWrong, F::kOffset, F::kSigma},
    {C::kDistancesContradict, "distances_contradict", kWrong, F::kRelative},
    {C::kDistanceWrong, "distance_wrong", kWrong, F::kRelative, F::kDifference},
    {C::kGeodeticDiffers, "geodetic_differs", kWrong, F::kDifference, F::kRatio},
    {C::kGeodeticAngleDiffers, "geodetic_angle_differs", kWrong, F::kDifferenceAngle, F::kRatio},
    {C::kNoDatum, "no_datum", kWeak, F::kDefect},
    {C::kDatumDefect, "datum_defect", kWeak, F::kDefect, F::kAzimuth, F::kSteepness},
    {C::kLocalGauge, "local_gauge", kNote},
    {C::kPositionsOnLine, "positions_on_line", kWeak},
    {C::kLevelByEdges, "level_by_edges", kWeak, F::kHeights, F::kSigmaAngle, F::kSigmaScale, F::kSigmaAzimuth},
    {C::kLevelByView, "level_by_view", kWeak, F::kHeights, F::kSigmaAngle, F::kSigmaScale, F::kSigmaAzimuth},
    {C::kLevelByLowerEdges, "level_by_lower_edges", kWeak, F::kHeights, F::kSigmaAngle, F::kSigmaScale,
     F::kSigmaAzimuth},
    {C::kLevelByAttitudes, "level_by_attitudes", kWeak, F::kHeights, F::kSigmaAngle, F::kSigmaScale, F::kSigmaAzimuth},
    {C::kHeightsRelative, "heights_relative", kNote},
    {C::kWeakRotation, "weak_rotation", kWeak, F::kAzimuth, F::kSteepness, F::kSigmaAngle, F::kExtent, F::kMotion,
     F::kReference},
    {C::kWeakScale, "weak_scale", kWeak, F::kSigmaScale, F::kExtent, F::kMotion, F::kReference},
    {C::kFocalAndHeight, "focal_and_height", kWeak, F::kCorrelation, F::kRatio},
    {C::kCameraAndPose, "camera_and_pose", kWeak, F::kCorrelation, F::kRatio},
    {C::kParameterNotDetermined, "parameter_not_determined", kWeak, F::kCount},
    {C::kScaleDrifts, "scale_drifts", kWeak, F::kCount},
    {C::kLooseImages, "loose_images", kWeak, F::kCount},
    {C::kNoBase, "no_base", kWeak, F::kCount},
    {C::kImagesLeftOut, "images_left_out", kWeak, F::kCount},
    {C::kMismatchesLeft, "mismatches_left", kWrong, F::kCount, F::kOf, F::kShare},
    {C::kGeodeticLeftOut, "geodetic_left_out", kWeak, F::kCount, F::kOf},
    {C::kWeakImages, "weak_images", kWeak, F::kCount, F::kRatio, F::kSigma, F::kTypicalSigma},
    {C::kInseparable, "inseparable", kWeak, F::kCorrelation},
    {C::kUndetermined, "undetermined", kWeak},
    {C::kFocalOfFlatScene, "focal_of_flat_scene", kWeak, F::kRelative},
    {C::kFocalAlongView, "focal_along_view", kWeak, F::kRelative},
    {C::kFocalOfFewImages, "focal_of_few_images", kWeak, F::kRelative},
    {C::kFocalMoved, "focal_moved", kWeak, F::kFocal, F::kFocalGiven, F::kRelative, F::kRatio},
    {C::kMovedAlongView, "moved_along_view", kWeak},
    {C::kMovedWhileRead, "moved_while_read", kWeak, F::kShare},
    {C::kPairsContradict, "pairs_contradict", kWeak, F::kCount, F::kMatches},
    {C::kPairsContradictWhileRead, "pairs_contradict_while_read", kWeak, F::kCount, F::kMatches},
    {C::kCriticalSurface, "critical_surface", kWeak},
    {C::kFewFitGiven, "few_fit_given", kWeak, F::kCount, F::kOf},
    {C::kLooseGiven, "loose_given", kWeak, F::kLimit, F::kCount},
    {C::kAdditionalFixed, "additional_fixed", kNote},
    {C::kAdditionalUncalibrated, "additional_uncalibrated", kNote},
    {C::kAdditionalSignificant, "additional_significant", kNote, F::kCount, F::kOf},
    {C::kPositionsUnused, "positions_unused", kNote},
    {C::kAttitudesUnused, "attitudes_unused", kNote},
    {C::kShiftUnused, "shift_unused", kNote},
    {C::kInstrument, "instrument", kNote, F::kValue, F::kValueSigma},
    {C::kInstrumentsMore, "instruments_more", kNote, F::kCount},
    {C::kSystematic, "systematic", kWeak, F::kValue, F::kValueSigma, F::kChance, F::kOffset, F::kOffsetPx,
     F::kDifferenceAngle, F::kDifference, F::kRatio},
    {C::kSystematicTakenUp, "systematic_taken_up", kNote, F::kValue, F::kValueSigma, F::kChance, F::kOffset,
     F::kOffsetPx, F::kDifferenceAngle, F::kDifference, F::kRatio},
    {C::kPositionsInOrder, "positions_in_order", kWeak, F::kCount, F::kCorrelation, F::kChance, F::kSigma},
    {C::kImageResidualsAlike, "image_residuals_alike", kNote, F::kCount, F::kCorrelation, F::kChance, F::kSigmaPx},
    {C::kResidualDistribution, "residual_distribution", kNote, F::kCount, F::kShare, F::kChance, F::kSigma,
     F::kSigmaPx},
    {C::kGrossErrorRejected, "gross_error_rejected", kWrong, F::kOffset, F::kOffsetPx, F::kDifferenceAngle, F::kSigma,
     F::kDifference},
    {C::kPartApart, "part_apart", kWeak, F::kCount},
    {C::kImagesAlone, "images_alone", kWeak, F::kCount},
    {C::kNoDepthMap, "no_depth_map", kNote},
    {C::kNotDownwards, "not_downwards", kNote},
    {C::kNoScale, "no_scale", kNote},
    {C::kNoGround, "no_ground", kNote},
    {C::kNoPreview, "no_preview", kNote},
    {C::kProjectionFitted, "projection_fitted", kNote, F::kOffsetPx},
    {C::kShearDropped, "shear_dropped", kNote, F::kValue, F::kOffsetPx},
    {C::kAdditionalDropped, "additional_dropped", kNote, F::kOffsetPx},
    {C::kImagesNotExported, "images_not_exported", kNote, F::kCount},
    {C::kDistortionFitted, "distortion_fitted", kNote, F::kOffsetPx},
    {C::kPairFewPoints, "pair_few_points", kWeak, F::kCount, F::kLimit},
    {C::kPairZonesEmpty, "pair_zones_empty", kWeak, F::kCount, F::kOf},
    {C::kPairParallax, "pair_parallax", kWrong, F::kOffsetPx, F::kSigmaPx},
    {C::kPairGeometry, "pair_geometry", kWeak, F::kRatio},
    {C::kPairBase, "pair_base", kWeak, F::kRatio, F::kSigma, F::kWanted},
    {C::kPairControlApart, "pair_control_apart", kWeak, F::kCount, F::kOf},
    {C::kPairLevelsDropped, "pair_levels_dropped", kWeak, F::kCount, F::kOf, F::kLimit},
    {C::kPairCellsMeasured, "pair_cells_measured", kWeak, F::kShare},
    {C::kControlContradicts, "control_contradicts", kWrong, F::kOffset, F::kTest, F::kLimit},
    {C::kResidualsLarge, "residuals_large", kWrong, F::kRatio, F::kChance},
    {C::kResidualsSmall, "residuals_small", kNote, F::kRatio, F::kChance},
    {C::kModelNoPoint, "model_no_point", kWrong},
    {C::kModelTurns, "model_turns", kWrong, F::kCount},
    {C::kModelNotFixed, "model_not_fixed", kWrong, F::kCount},
    {C::kModelNoControl, "model_no_control", kWrong},
    {C::kModelFewPoints, "model_few_points", kWeak, F::kCount, F::kLimit},
    {C::kModelPointsOnLine, "model_points_on_line", kWeak, F::kCount, F::kRatio},
    {C::kModelUnchecked, "model_unchecked", kWeak, F::kValue},
    {C::kPairMakesNoModel, "pair_makes_no_model", kWrong},
    {C::kNothingChecks, "nothing_checks", kWeak},
    {C::kMeasurementContradicts, "measurement_contradicts", kWrong, F::kTest, F::kLimit},
    {C::kMeasurementsRejected, "measurements_rejected", kNote, F::kCount, F::kOf},
    {C::kFewPoints, "few_points", kWeak, F::kCount, F::kLimit},
    {C::kSolutionsOpen, "solutions_open", kWrong, F::kCount},
    {C::kSolutionChosen, "solution_chosen", kNote, F::kCount},
    {C::kPointsBehind, "points_behind", kWrong, F::kCount, F::kOf},
    {C::kPoseWeak, "pose_weak", kWeak, F::kRatio},
    {C::kDangerCircle, "danger_circle", kWeak, F::kRadius, F::kOffset},
    {C::kPoseOpen, "pose_open", kWeak},
    {C::kSeenOnce, "seen_once", kWeak, F::kCount},
    {C::kRaysWithoutPoint, "rays_without_point", kWrong, F::kCount},
    {C::kRaysNarrow, "rays_narrow", kWeak, F::kCount, F::kAngle, F::kLimit},
    {C::kRaysMiss, "rays_miss", kWrong, F::kCount, F::kTest, F::kLimit},
    {C::kOrientationsExact, "orientations_exact", kNote},
    {C::kCombinationsOpen, "combinations_open", kWeak, F::kCount},
    {C::kControlFew, "control_few", kWeak, F::kCount, F::kHeights},
    {C::kControlOnLine, "control_on_line", kWeak, F::kCount, F::kRatio},
    {C::kControlRejected, "control_rejected", kNote, F::kCount, F::kOf},
    {C::kRankNearThree, "rank_near_three", kWeak, F::kRatio},
    {C::kNotInAllImages, "not_in_all_images", kNote, F::kCount, F::kOf},
    {C::kOneCalibrationRefuted, "one_calibration_refuted", kWrong, F::kRatio, F::kChance},
    {C::kStatedCameraRefuted, "stated_camera_refuted", kWrong, F::kRatio, F::kChance},
    {C::kNoEuclideanForm, "no_euclidean_form", kWrong},
    {C::kCameraFitsNot, "camera_fits_not", kWrong},
    {C::kPrincipalDistanceWeak, "principal_distance_weak", kWeak, F::kRelative},
    {C::kFiducialsContradict, "fiducials_contradict", kWrong, F::kRatio, F::kOffset},
    {C::kFiducialsLeftOut, "fiducials_left_out", kWeak, F::kCount, F::kOf},
    {C::kFiducialsMissing, "fiducials_missing", kNote, F::kCount, F::kOf},
    {C::kFiducialsUnknown, "fiducials_unknown", kWrong, F::kCount},
    {C::kReadingsContested, "readings_contested", kWeak, F::kCount},
    {C::kReadingsGross, "readings_gross", kNote, F::kCount},
    {C::kSeenFromBehind, "seen_from_behind", kNote},
    {C::kEditUnfit, "edit_unfit", kWrong, F::kLine},
};

struct FigureRow {
  F name;
  std::string_view word, unit;
};

constexpr FigureRow kFigures[] = {
    {F::kOffset, "offset_m", "m"},
    {F::kOffsetPlan, "offset_plan_m", "m"},
    {F::kOffsetHeight, "offset_height_m", "m"},
    {F::kEast, "east_m", "m"},
    {F::kNorth, "north_m", "m"},
    {F::kUp, "up_m", "m"},
    {F::kOffsetPx, "offset_px", "px"},
    {F::kPixelX, "x_px", "px"},
    {F::kPixelY, "y_px", "px"},
    {F::kLine, "line", "1"},
    {F::kCount, "count", "1"},
    {F::kOf, "of", "1"},
    {F::kCameras, "cameras", "1"},
    {F::kHeights, "heights", "1"},
    {F::kMatches, "matches", "1"},
    {F::kLimit, "limit", "1"},
    {F::kWidth, "width_px", "px"},
    {F::kHeight, "height_px", "px"},
    {F::kFocal, "focal_px", "px"},
    {F::kFocalLowest, "lowest_focal_px", "px"},
    {F::kFocalHighest, "highest_focal_px", "px"},
    {F::kLowest, "lowest_m", "m"},
    {F::kHighest, "highest_m", "m"},
    {F::kCorrelation, "correlation", "1"},
    {F::kRatio, "ratio", "1"},
    {F::kSigma, "sigma_m", "m"},
    {F::kSigmaPx, "sigma_px", "px"},
    {F::kSigmaAngle, "sigma_deg", "deg"},
    {F::kSigmaAzimuth, "sigma_azimuth_deg", "deg"},
    {F::kSigmaScale, "sigma_scale", "1"},
    {F::kTypicalSigma, "typical_sigma_m", "m"},
    {F::kReference, "reference_sigma_m", "m"},
    {F::kExtent, "extent_m", "m"},
    {F::kMotion, "motion_m", "m"},
    {F::kAzimuth, "azimuth_deg", "deg"},
    {F::kSteepness, "steepness", "1"},
    {F::kDefect, "degrees_of_freedom", "1"},
    {F::kShare, "share", "1"},
    {F::kRelative, "relative", "1"},
    {F::kDifference, "difference_m", "m"},
    {F::kDifferenceAngle, "difference_deg", "deg"},
    {F::kValue, "value", "1"},
    {F::kValueSigma, "value_sigma", "1"},
    {F::kChance, "chance", "1"},
    {F::kFocalGiven, "focal_given_px", "px"},
    {F::kTest, "test", "1"},
    {F::kWanted, "wanted_m", "m"},
    {F::kAngle, "angle_deg", "deg"},
    {F::kRadius, "radius_m", "m"},
};

struct KindRow {
  SubjectKind kind;
  std::string_view word;
};

constexpr KindRow kKinds[] = {
    {SubjectKind::kBlock, "block"},
    {SubjectKind::kImage, "image"},
    {SubjectKind::kCamera, "camera"},
    {SubjectKind::kTiePoint, "tie_point"},
    {SubjectKind::kControlPoint, "control_point"},
    {SubjectKind::kGeodetic, "geodetic"},
    {SubjectKind::kStrip, "strip"},
    {SubjectKind::kSetup, "setup"},
    {SubjectKind::kLevel, "level"},
    {SubjectKind::kPlane, "plane"},
    {SubjectKind::kLine, "line"},
    {SubjectKind::kFile, "file"},
    {SubjectKind::kCrs, "crs"},
    {SubjectKind::kProduct, "product"},
    {SubjectKind::kModel, "model"},
    {SubjectKind::kPoint, "point"},
    {SubjectKind::kMark, "mark"},
};

struct AspectRow {
  Aspect aspect;
  std::string_view word;
};

constexpr AspectRow kAspects[] = {
    {Aspect::kWhole, "whole"},
    {Aspect::kPosition, "position"},
    {Aspect::kAttitude, "attitude"},
    {Aspect::kParameter, "parameter"},
    {Aspect::kOrientation, "orientation"},
    {Aspect::kLeverArm, "lever_arm"},
    {Aspect::kShift, "shift"},
    {Aspect::kDrift, "drift"},
    {Aspect::kBoresight, "boresight"},
    {Aspect::kTimeOffset, "time_offset"},
    {Aspect::kHeight, "height"},
    {Aspect::kTilt, "tilt"},
    {Aspect::kDirection, "direction"},
    {Aspect::kScale, "scale"},
    {Aspect::kPlan, "plan"},
    {Aspect::kRotation, "rotation"},
    {Aspect::kTwoRotations, "two_rotations"},
    {Aspect::kSomeShift, "some_shift"},
    {Aspect::kDistance, "distance"},
    {Aspect::kTiltX, "tilt_x"},
    {Aspect::kTiltY, "tilt_y"},
    {Aspect::kPositionX, "position_x"},
    {Aspect::kPositionY, "position_y"},
    {Aspect::kVerticalDatum, "vertical_datum"},
    {Aspect::kAssignment, "assignment"},
    {Aspect::kBowl, "bowl"},
    {Aspect::kAffinity, "affinity"},
    {Aspect::kAdditional, "additional"},
    {Aspect::kRollingShutter, "rolling_shutter"},
    {Aspect::kRefraction, "refraction"},
};

struct RemedyRow {
  RemedyCode code;
  std::string_view word;
};

using R = RemedyCode;
constexpr RemedyRow kRemedies[] = {
    {R::kSetOption, "set_option"},
    {R::kFixDatum, "fix_datum"},
    {R::kGiveScale, "give_scale"},
    {R::kGiveControlForAttitude, "give_control_for_attitude"},
    {R::kGiveHeightsForTilt, "give_heights_for_tilt"},
    {R::kGiveControlOffLine, "give_control_off_line"},
    {R::kGiveControlOffThatLine, "give_control_off_that_line"},
    {R::kGivePosition, "give_position"},
    {R::kGiveHeight, "give_height"},
    {R::kGivePlan, "give_plan"},
    {R::kGiveMoreCoordinates, "give_more_coordinates"},
    {R::kMeasureTiePoints, "measure_tie_points"},
    {R::kMeasureTiePointsBetween, "measure_tie_points_between"},
    {R::kSpreadTiePoints, "spread_tie_points"},
    {R::kMeasureGroundPoints, "measure_ground_points"},
    {R::kAddImagesFromElsewhere, "add_images_from_elsewhere"},
    {R::kAddTripleOverlap, "add_triple_overlap"},
    {R::kWidenControl, "widen_control"},
    {R::kWidenControlInPlan, "widen_control_in_plan"},
    {R::kAddCrossStrip, "add_cross_strip"},
    {R::kVaryHeights, "vary_heights"},
    {R::kRotateImages, "rotate_images"},
    {R::kReachCorners, "reach_corners"},
    {R::kFewerParameters, "fewer_parameters"},
    {R::kCalibrateCamera, "calibrate_camera"},
    {R::kFlyBack, "fly_back"},
    {R::kSpreadShapePoints, "spread_shape_points"},
    {R::kAddHeightsOrOblique, "add_heights_or_oblique"},
    {R::kMeasureMoreFromSetup, "measure_more_from_setup"},
    {R::kFlyBackAndAcross, "fly_back_and_across"},
    {R::kAddCrossStripOrControl, "add_cross_strip_or_control"},
    {R::kGiveOne, "give_one"},
    {R::kAddDistances, "add_distances"},
    {R::kAddSideViews, "add_side_views"},
    {R::kHoldStill, "hold_still"},
    {R::kRemoveRepeats, "remove_repeats"},
    {R::kLeaveSurface, "leave_surface"},
    {R::kGiveThreeControlPoints, "give_three_control_points"},
    {R::kAddStripOrControl, "add_strip_or_control"},
    {R::kLookForMarks, "look_for_marks"},
    {R::kLookForPoints, "look_for_points"},
    {R::kLookAtDistance, "look_at_distance"},
    {R::kAddDistance, "add_distance"},
    {R::kMeasureInAnother, "measure_in_another"},
    {R::kFolderOfEachFlight, "folder_of_each_flight"},
    {R::kSeeAdjustment, "see_adjustment"},
    {R::kCorrectMarks, "correct_marks"},
    {R::kLookForNames, "look_for_names"},
    {R::kLookForDatum, "look_for_datum"},
    {R::kSpreadPairPoints, "spread_pair_points"},
    {R::kGiveControlInCorners, "give_control_in_corners"},
    {R::kLengthenBase, "lengthen_base"},
    {R::kShareModelPoints, "share_model_points"},
    {R::kStateSigmas, "state_sigmas"},
    {R::kMeasureMorePoints, "measure_more_points"},
    {R::kMeasureAgain, "measure_again"},
    {R::kSpreadControl, "spread_control"},
    {R::kLeaveCircle, "leave_circle"},
    {R::kGiveFourthPoint, "give_fourth_point"},
    {R::kGiveHeightMore, "give_height_more"},
    {R::kGiveControlAtEdges, "give_control_at_edges"},
    {R::kCheckAssignment, "check_assignment"},
    {R::kStateOrientationSigmas, "state_orientation_sigmas"},
    {R::kMeasureInMoreImages, "measure_in_more_images"},
    {R::kTakeWiderBase, "take_wider_base"},
    {R::kGivePrincipalDistance, "give_principal_distance"},
    {R::kReadMarksAgain, "read_marks_again"},
    {R::kCompareMarkNames, "compare_mark_names"},
};

static_assert(is_in_order(kCodes, kFindingCodes, &CodeRow::code));
static_assert(is_in_order(kFigures, kFigureNames, &FigureRow::name));
static_assert(is_in_order(kKinds, kSubjectKinds, &KindRow::kind));
static_assert(is_in_order(kAspects, kAspectsOfSubjects, &AspectRow::aspect));
static_assert(is_in_order(kRemedies, kRemedyCodes, &RemedyRow::code));

// The row of an enumerator; the last one for a number that is none, which damaged files may hold.
template <class Row, std::size_t Size, class Enum>
const Row& row_in(const Row (&rows)[Size], Enum value) {
  return rows[std::min(static_cast<std::size_t>(value), Size - 1)];
}

const CodeRow& row_of(C code) { return row_in(kCodes, code); }

Subject named(SubjectKind kind, std::string name) {
  Subject subject(kind, Subject::kAll);
  subject.name = std::move(name);
  return subject;
}

}  // namespace

Subject Subject::geodetic(std::size_t index) { return {SubjectKind::kGeodetic, static_cast<std::uint32_t>(index)}; }

Subject Subject::file(std::string name) { return named(SubjectKind::kFile, std::move(name)); }

Subject Subject::crs(std::string name) { return named(SubjectKind::kCrs, std::move(name)); }

Subject Subject::model(std::string name) { return named(SubjectKind::kModel, std::move(name)); }

Subject Subject::control_named(std::string name) { return named(SubjectKind::kControlPoint, std::move(name)); }

Subject Subject::point(std::string name) { return named(SubjectKind::kPoint, std::move(name)); }

Subject Subject::mark(std::string name) { return named(SubjectKind::kMark, std::move(name)); }

Subject Subject::image_named(std::string name) { return named(SubjectKind::kImage, std::move(name)); }

std::optional<ImageId> Subject::image() const {
  if (kind != SubjectKind::kImage || id == kAll) return std::nullopt;
  return ImageId{id};
}

std::optional<CameraId> Subject::camera() const {
  if (kind != SubjectKind::kCamera || id == kAll) return std::nullopt;
  return CameraId{id};
}

std::optional<ControlId> Subject::control() const {
  if (kind != SubjectKind::kControlPoint || id == kAll) return std::nullopt;
  return ControlId{id};
}

std::optional<double> Finding::figure(FigureName name) const {
  const auto found = std::ranges::find(figures, name, &Figure::name);
  if (found == figures.end()) return std::nullopt;
  return found->value;
}

std::vector<double> Finding::figures_of(FigureName name) const {
  std::vector<double> values;
  for (const Figure& one : figures)
    if (one.name == name) values.push_back(one.value);
  return values;
}

Finding finding_of(FindingCode code, std::vector<Subject> subjects, std::vector<Figure> figures,
                   std::vector<Remedy> remedies, std::string detail) {
  return {code, severity_of(code), std::move(subjects), std::move(figures), std::move(remedies), std::move(detail)};
}

std::string_view word_of(FindingCode code) { return row_of(code).word; }

std::string_view word_of(Severity severity) {
  return severity == Severity::kNote ? "note" : severity == Severity::kWeak ? "weak" : "wrong";
}

std::string_view word_of(FigureName name) { return row_in(kFigures, name).word; }

std::string_view unit_of(FigureName name) { return row_in(kFigures, name).unit; }

std::string_view word_of(SubjectKind kind) { return row_in(kKinds, kind).word; }

std::string_view word_of(Product product) {
  return product == Product::kSurfaceModel   ? "surface_model"
         : product == Product::kTerrainModel ? "terrain_model"
                                             : "orthophoto";
}

std::string_view word_of(Aspect aspect) { return row_in(kAspects, aspect).word; }

std::string_view word_of(RemedyCode code) { return row_in(kRemedies, code).word; }

Severity severity_of(FindingCode code) { return row_of(code).severity; }

std::span<const FigureName> figures_of(FindingCode code) {
  return std::span(row_of(code).figures).first(row_of(code).figure_count);
}

std::optional<FindingCode> finding_code_named(std::string_view word) {
  const auto found = std::ranges::find(kCodes, word, &CodeRow::word);
  if (found == std::end(kCodes)) return std::nullopt;
  return found->code;
}

}  // namespace collinea
