// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "collinea/adjust/bundle.h"
#include "collinea/base/options.h"
#include "collinea/quality/conditioning.h"
#include "collinea/quality/datum_points.h"
#include "collinea/quality/internal/camera_poses.h"
#include "collinea/quality/internal/covariance.h"
#include "collinea/quality/internal/point_precision.h"
#include "collinea/quality/internal/reliability.h"
#include "collinea/quality/internal/weakness.h"
#include "collinea/quality/internal/whitened_positions.h"
#include "collinea/quality/systematics.h"

namespace collinea {

/// How a block is adjusted and what is asked of its quality. Covariances of images and cameras, conditioning and
/// weaknesses are always computed.
struct ExamineOptions {
  AdjustOptions adjust;
  bool point_covariances = false;
  bool reliability = false;       ///< test every observation for a gross error, and say what would be found
  TestOptions test;               ///< how
  SystematicOptions systematics;  ///< errors that many observations have in common
  DatumPoints datum;              ///< of a free network; none: all tie points
};

/// An adjustment with what is known of its quality. Covariances are by the given sigmas (times sigma_scale()^2 when
/// these are only known up to scale); they, and with them all that follows, are empty when something is not determined.
struct Examined : Adjusted {
  /// [rotation (rad, in world), centre (m, in world)]: true rotation = rotation * rotation_by(e). That is a turn of the
  /// world before the camera, against which omega, phi and kappa count; see pose_covariances() and
  /// covariance_of_angles().
  std::map<ImageId, Matrix6d> pose_covariance;
  std::map<CameraId, MatrixPd> camera_covariance;  ///< of Camera::params, zero for those fixed
  std::vector<Eigen::Matrix3d> point_covariance;   ///< [m^2], parallel to points; when asked for
  std::vector<PointPrecision>
      point_precisions;  ///< at up to 2000 of the tie points with three rays or more, evenly taken
  std::vector<CameraPoseCorrelation> camera_pose_correlations;
  std::vector<Finding> inseparable;  ///< pairs of unknowns that hardly differ in what they do (correlation beyond 0.99)
  std::optional<Finding> undetermined;  ///< what is not determined; nothing when everything is
  Conditioning conditioning;
  std::vector<Finding> weaknesses;          ///< none: everything is well determined
  std::optional<Reliability> reliability;   ///< when asked for
  std::vector<SystematicTest> systematics;  ///< when asked for
  /// Residuals of positions made independent in the order flown, with reliability; for residual_tests().
  std::vector<WhitenedPosition> whitened_positions;
};

/// Examines an adjusted block: covariances, conditioning, weaknesses and, when asked for, reliability (see the headers
/// of each for model and formula). Uses up `solved`. Also fills what Adjusted keeps of standard deviations: of unknowns
/// beside images, cameras and points, of control and check points, of measurements on the ground.
///
/// Rank and datum: covariances of poses and points of a block that nothing fixes refer to all its tie points. Where
/// something else is undetermined, `undetermined` names it and only weaknesses that need no covariance are looked for.
/// ExamineOptions::datum takes other points in their place; where the datum is complete it changes nothing.
///
/// Example:
///
///     COLLINEA_TRY(Solved solved, solve_bundle(block, scope, {.settle_points = true}, run));
///     COLLINEA_TRY(const Examined examined, examine(std::move(solved), {.reliability = true}, run));
///     for (const TestedObservation& one : examined.reliability->suspects) ...
///
/// Tests of single observations ask for AdjustOptions::settle_points. Cost: one factor and its selected inverse, at
/// most some forty solutions with that factor, three for each control point, and a small system for each tie point; for
/// systematic errors one more pass over the rays and some sixty solutions.
/// Errors: kBadInput (options), kIllPosed (points chosen for the datum that do not tell position, attitude and scale of
/// what is free of these), kCancelled.
[[nodiscard]] Result<Examined> examine(Solved solved, const ExamineOptions& options, const Run& run);

/// Adjusts and examines. Errors: those of adjust(), and of the above.
[[nodiscard]] Result<Examined> examine(const Block& block, const AdjustScope& scope, const ExamineOptions& options,
                                       const Run& run);

/// The same, by an adjuster that is used again and again.
[[nodiscard]] Result<Examined> examine(Adjuster& adjuster, const Block& block, const AdjustScope& scope,
                                       const ExamineOptions& options, const Run& run);

/// Adjusts, and fills what Adjusted keeps of standard deviations of control and check points alone: a fraction of the
/// work of examine(). Errors: those of adjust().
[[nodiscard]] Result<Adjusted> adjust_with_control_precision(Adjuster& adjuster, const Block& block,
                                                             const AdjustScope& scope, const AdjustOptions& options,
                                                             const Run& run);
/// The same, going on from where it has come three times if it has not converged: half way everything looks wrong. The
/// block then takes poses, cameras and points of those. Adds the adjustments to `adjustments`.
[[nodiscard]] Result<Examined> examine_to_the_end(Adjuster& adjuster, Block& block, const AdjustScope& scope,
                                                  const ExamineOptions& options, const Run& run, int& adjustments);

}  // namespace collinea
