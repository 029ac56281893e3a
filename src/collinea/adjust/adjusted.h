// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "collinea/adjust/unknowns.h"
#include "collinea/block/block.h"

namespace collinea {

/// A measurement on the ground after the adjustment.
struct GroundDifference {
  std::uint32_t observation = 0;  ///< place in Block::ground
  bool used = false;              ///< it took part; false: only compared
  double adjusted = 0;            ///< [m] or [rad]
  double difference = 0;          ///< adjusted minus given
  /// With covariances: of `adjusted`, by the given sigmas, and what `difference` is expected to be. NaN: not known.
  double sigma = std::numeric_limits<double>::quiet_NaN();
  double difference_sigma = std::numeric_limits<double>::quiet_NaN();
};

/// The position of an image against what its receiver said.
struct PositionDifference {
  ImageId image;
  Eigen::Vector3d difference_m;  ///< adjusted minus given; NaN on axes that were not given
  double weight = 1;             ///< by the robust loss; below 1: partly disbelieved
};

/// The attitude of an image against what was given.
struct AttitudeDifference {
  ImageId image;
  Eigen::Vector3d difference_rad;  ///< adjusted minus given, less the boresight: a turn about x, y, z of the world
};

/// A control or check point after the adjustment.
struct ControlDifference {
  ControlId point;
  bool used = false;  ///< it took part; false: check point, intersected from the images that took part or were held
  int rays = 0;       ///< such images it was measured in
  std::optional<Eigen::Vector3d> position_in_world;  ///< nothing when the rays do not intersect
  Eigen::Vector3d difference_m = Eigen::Vector3d::Constant(
      std::numeric_limits<double>::quiet_NaN());  ///< estimated minus given, in the world frame; NaN: not surveyed
  /// With covariances: of position_in_world [m^2], by the given sigmas (of a check point without its survey) ...
  std::optional<Eigen::Matrix3d> covariance_m2;
  /// ... and what difference_m is expected to be, by the block's covariance times sigma0^2 and the survey as given.
  /// NaN: not known.
  Eigen::Vector3d difference_sigma_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
};

/// The outcome of a bundle adjustment. Residuals are observed minus computed.
struct Adjusted {
  std::map<ImageId, Rigid3> cam_from_world;                 ///< of the images that moved
  std::map<CameraId, Camera> cameras;                       ///< that were calibrated
  std::vector<std::pair<PointId, Eigen::Vector3d>> points;  ///< that moved, ascending [m]

  std::vector<std::uint32_t>
      observations;  ///< of tie points that took part: their places in Block::observations, ascending
  std::vector<Eigen::Vector2d> residuals_px;  ///< one for each of them; NaN when the point is not seen by the image
  std::vector<PositionDifference> positions;
  std::vector<ControlDifference> control;             ///< every control and check point with a ray, and those that
                                                      ///< measurements on the ground alone determine, ascending
  std::vector<Eigen::Vector2d> control_residuals_px;  ///< in the order of Block::control_observations; NaN when unknown
  std::vector<GroundDifference> ground;               ///< those whose two points take part, ascending
  std::vector<EstimatedUnknown> extras;               ///< unknowns beside images, cameras and points
  std::vector<AttitudeDifference> attitudes;          ///< ascending
  std::vector<ImageId> images_left_out;  ///< free, but with too few observations to be determined; not moved

  double sigma0 = 0;                              ///< a posteriori, of unit weight: 1 when the given sigmas are true,
                                                  ///< whatever the loss
  long redundancy = 0;                            ///< observations (priors too) minus unknowns plus rank defect
  long observation_count = 0, unknown_count = 0;  ///< coordinates (of rays that see their point); single unknowns
  int rank_defect = 0;  ///< of the datum: 7 for a free block, 0 when positions, control or held images fix it
  std::string datum;    ///< what fixes place, attitude and scale, in words
  int iterations = 0;
  double initial_cost = 0, final_cost = 0;  ///< sum of squared whitened residuals after the loss
  bool converged = false;
  double last_step_sigmas = 0;  ///< length of the last step of images and cameras, in their standard deviations
};

/// What the square roots of covariances are multiplied by to be standard deviations: sigma0, or 1 where that says
/// nothing: without redundancy, and where observations agree to rounding, as those of a planned block do.
[[nodiscard]] inline double sigma_scale(const Adjusted& adjusted) {
  return adjusted.redundancy > 0 && adjusted.sigma0 > 1e-9 ? adjusted.sigma0 : 1;
}

/// Writes poses, cameras and points of the adjustment into the block.
void apply(const Adjusted& adjusted, Block& block);

}  // namespace collinea
