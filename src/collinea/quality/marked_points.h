// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "collinea/adjust/adjust_options.h"
#include "collinea/adjust/adjust_scope.h"
#include "collinea/adjust/solved.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/quality/internal/reliability.h"

namespace collinea {

/// A point in an image, as a person or a target finder marked it.
struct BlockMark {
  ImageId image;
  Eigen::Vector2d pixel;
  double sigma_px = 1;  ///< as Observation::sigma_px
  PixelShape shape = {};
};

/// Where a point was surveyed: as ControlPoint has it.
struct SurveyedPosition {
  Eigen::Vector3d position_in_world;
  Eigen::Vector3d sigma_m;  ///< infinite where it was not; 0 counts as a tenth of a millimetre
  Eigen::Vector3d correlation = Eigen::Vector3d::Zero();
  ControlRole role = ControlRole::kControl;  ///< kCheck: only compared
};

/// A point that is known by its marks, and by coordinates where it was surveyed.
struct BlockPoint {
  std::vector<BlockMark> marks;
  std::optional<SurveyedPosition> surveyed = {};
};

/// What the block and all other marks say of a mark.
struct BlockMarkTest {
  static constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  /// Marked minus adjusted; NaN: its point has no position, or its image takes no part.
  Eigen::Vector2d residual_px{kNaN, kNaN};
  Eigen::Vector2d redundancy{0, 0};  ///< of column and row, 0 to 1: the part of a blunder that its own residual shows
  Eigen::Vector2d w{kNaN, kNaN};     ///< residual over its standard deviation (Baarda's w); NaN without redundancy
  /// With the level and power asked for; infinite without redundancy.
  Eigen::Vector2d minimal_detectable_bias_px = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
};

/// A measurement on the ground between two points, or of one that lies on a shape (GeodeticObservation::from and to do
/// not count). With the role kCheck it takes no part.
struct PointLink {
  std::size_t from = 0, to = 0;  ///< numbers of points
  GeodeticObservation observation;
};

/// A marked point after the adjustment.
struct AdjustedMark {
  std::optional<Eigen::Vector3d> position_in_world;  ///< nothing: its marks do not determine it
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  /// Adjusted minus surveyed, and what is expected of it (of control a residual, of a check point with its survey);
  /// NaN on axes that were not surveyed.
  Eigen::Vector3d difference_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d difference_sigma_m = difference_m;
  std::vector<BlockMarkTest> marks;  ///< parallel to BlockPoint::marks
};

/// The block and all marked points together.
struct AdjustedMarks {
  std::vector<AdjustedMark> points;  ///< parallel to what was given
  Eigen::MatrixXd covariance_m2;     ///< of all points that have a position and take part together; 3 rows each
  double sigma0 = 1;                 ///< of the block without the marks; its square is in the covariances
  bool placed = true;  ///< false: nothing fixes the block, and there is too little control to place it; its own datum
                       ///< holds, and coordinates are only compared
  bool converged = false;
};

/// What becomes of the control that a block has.
enum class BlockControl : std::uint8_t {
  kLeftOut,  ///< its points are those that are marked, and what was measured on the ground between them is given with
             ///< them
  kKept      ///< it takes part; the points that are marked are others
};

/// The adjustment of an oriented block with points that a person marks, brought up to date in milliseconds after each
/// mark.
///
/// Model. The block is adjusted once with the control that it has, and linearised there without it. Of what it then
/// knows of the unknowns u of images and cameras (covariance Q of those that have marks), marks l with their sigmas,
/// and coordinates where control was surveyed, follow
///
///     l + v = f(u, x),    S = P^-1 + A Q A',    dx = (B' S^-1 B + P_x)^-1 (B' S^-1 w + P_x w_x),    du = Q A' S^-1 (w
///     - B dx)
///
/// with the derivatives A by u and B by the points x: the same estimate, covariances and tests as the adjustment of
/// everything together (sequential adjustment, Mikhail 1976; docs/theory/reliability.md), exactly so for linear
/// equations; the equations of the marks are linearised anew until nothing moves, those of the tie points are not.
/// Redundancy and w of a mark are the diagonal of S^-1 - S^-1 B (..)^-1 B' S^-1 and the residual over its root (Baarda
/// 1968).
///
/// Check points take no part: they are intersected from the images as all others leave them; but those that something
/// was measured to on the ground take part without their coordinates. Points that were not surveyed are tie points.
///
/// Measurements on the ground (PointLink) join the normal equations of the points, with the orientations of set-ups and
/// what describes shapes as unknowns. Those to points without a position, and to shapes that their points do not
/// determine, take no part; nor do any in a block that nothing places.
///
/// Rank and datum. Where nothing fixes position, attitude and scale of the block, its seven motions are unknowns
/// without observations: control on three axes of three points off a line determines them. Blocks whose free parts are
/// several, or that only some motions of are free, are refused (kUnsupported). Shapes need a block with a datum.
///
/// Cost: one adjustment and its factor at the beginning; then six solutions with that factor for each image that gets
/// its first mark, and a system of two equations a mark.
///
/// Example:
///
///     COLLINEA_TRY(MarkedBlock marked, MarkedBlock::of(block, scope, options, BlockControl::kLeftOut, run));
///     const AdjustedMarks now = marked.adjust(points);
///     now.points[0].marks[2].w ...
class MarkedBlock {
 public:
  static constexpr std::size_t kMostMarks = 1000;

  /// Adjusts the block without the points that are marked. Errors: those of adjust(); kIllPosed when images are not
  /// determined; kUnsupported as above.
  static Result<MarkedBlock> of(Block block, const AdjustScope& scope, const AdjustOptions& options,
                                BlockControl control, const Run& run);
  MarkedBlock(MarkedBlock&&) noexcept;
  MarkedBlock& operator=(MarkedBlock&&) noexcept;
  ~MarkedBlock();

  /// The block with these marks. Points without two marks (or one and coordinates on three axes) have no position.
  /// Errors: kBadInput (sigmas not positive, links to points that there are not), kUnsupported (more than kMostMarks).
  [[nodiscard]] Result<AdjustedMarks> adjust(std::span<const BlockPoint> points, const TestOptions& test = {},
                                             std::span<const PointLink> ground = {});

  /// The block as adjusted without the points.
  [[nodiscard]] const Block& block() const;

 private:
  struct State;
  explicit MarkedBlock(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collinea
