// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/plan/planned_block.h"

namespace collinea {

/// Standard deviations over the area, east, north and height: root mean square and, of plan (the longer of both axes)
/// and height, the largest with its position.
struct AreaSigma {
  Eigen::Vector3d rms_m = Eigen::Vector3d::Zero();
  double worst_plan_m = 0, worst_height_m = 0;
  Eigen::Vector2d worst_plan_at{0, 0}, worst_height_at{0, 0};
  std::size_t cells = 0, empty = 0;  ///< cells of the area; those that fewer than two images show
};

/// What is predicted of a cell of the map.
struct CellPrecision {
  std::size_t cell = 0;
  Eigen::Vector2d position;       ///< plan coordinates of its middle
  Eigen::Matrix3d covariance_m2;  ///< east, north, height
  int images = 0;

  [[nodiscard]] Eigen::Vector3d sigma_m() const { return covariance_m2.diagonal().cwiseSqrt(); }
  [[nodiscard]] double plan_m() const { return std::sqrt(std::max(covariance_m2(0, 0), covariance_m2(1, 1))); }
};

/// Tie points by the number of images they are found in.
struct RaysPrecision {
  int from = 2, to = 2;  ///< to: 0: no end
  std::size_t points = 0;
  Eigen::Vector3d rms_m = Eigen::Vector3d::Zero();
};

/// All that is predicted of a planned block.
struct Precision {
  PlannedBlock planned;
  Examined adjusted;  ///< covariances by the given sigmas
  std::vector<CellPrecision> cells;
  AreaSigma area;
  std::vector<RaysPrecision> rays;
  Eigen::Vector3d pose_rms_m = Eigen::Vector3d::Zero(),
                  rotation_rms_rad = Eigen::Vector3d::Zero();  ///< turns: in the camera
};

/// Adjusts the block as planned and tells the standard deviations of everything. Errors: those of the adjustment; a
/// block whose datum is not fixed still has an answer, with its weaknesses.
[[nodiscard]] Result<Precision> predicted(PlannedBlock planned, const Run& run);

/// What may be added to a survey.
enum class GainBy : std::uint8_t { kControlPoint, kCrossStrip, kPositions };

/// What something more would gain.
struct Gain {
  GainBy by{};
  std::optional<Eigen::Vector2d> position;  ///< of a point
  Eigen::Vector3d sigma_m{0, 0, 0};         ///< with which it is measured: points, positions
  AreaSigma area;                           ///< with it
};

/// One more control point where it gains most: of the position that is known worst and others spread between the points
/// there are, `candidates` in all, that which lowers the root mean square of all three axes most. Nothing when no
/// position is left. The survey is as good as the layout says.
[[nodiscard]] Result<std::optional<Gain>> one_more_point(const FlightPlan& plan,
                                                         const std::vector<PlannedPoint>& points,
                                                         const Eigen::Vector3d& sigma_m,
                                                         const MeasurementOptions& options, const Precision& now,
                                                         int count, const Run& run);

/// The true errors of simulated blocks against what was predicted.
struct Trials {
  int blocks = 0;
  Eigen::Vector3d cell_ratio = Eigen::Vector3d::Zero();  ///< root mean square of error / sigma: 1 is expected
  double cell_chi2 = 0, pose_chi2 = 0, camera_chi2 = 0;  ///< mean of e' C^-1 e over its degrees of freedom: 1;
                                                         ///< NaN where nothing of the kind is unknown
  long cells = 0, poses = 0, cameras = 0;
};

/// Adjusts `blocks` simulated blocks with all their errors and compares. Errors: those of the adjustment.
[[nodiscard]] Result<Trials> tried(const Precision& predicted, int blocks, const Run& run);

}  // namespace collinea
