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

#include "collinea/adjust/datum_sources.h"
#include "collinea/adjust/unknowns.h"
#include "collinea/block/block.h"
#include "collinea/block/differences.h"
#include "collinea/math/robust.h"

namespace collinea {

/// The attitude of an image against what was given.
struct AttitudeDifference {
  ImageId image;
  Eigen::Vector3d difference_rad;  ///< adjusted minus given, less the boresight: a turn about x, y, z of the world
};

/// The outcome of a bundle adjustment. Residuals are observed minus computed.
struct Adjusted {
  std::map<ImageId, Rigid3> cam_from_world;                 ///< of the images that moved
  std::map<CameraId, Camera> cameras;                       ///< that were calibrated
  std::vector<std::pair<PointId, Eigen::Vector3d>> points;  ///< that moved, ascending [m]

  std::vector<std::uint32_t>
      observations;  ///< of tie points that took part: their indices in Block::observations, ascending
  std::vector<Eigen::Vector2d> residuals_px;  ///< one for each of them; NaN when the point is not seen by the image
  std::vector<PositionDifference> positions;
  std::vector<ControlDifference> control;             ///< every control and check point with a ray, and those that
                                                      ///< measurements on the ground alone determine, ascending
  std::vector<Eigen::Vector2d> control_residuals_px;  ///< in the order of Block::control_observations; NaN when unknown
  std::vector<GeodeticDifference> geodetic;           ///< those whose two points take part, ascending
  std::vector<EstimatedUnknown> auxiliaries;          ///< unknowns beside images, cameras and points
  std::vector<AttitudeDifference> attitudes;          ///< ascending
  std::vector<ImageId> images_left_out;  ///< free, but with too few observations to be determined; not moved

  double sigma0 = 0;                              ///< a posteriori, of unit weight: 1 when the given sigmas are true,
                                                  ///< whatever the loss
  long redundancy = 0;                            ///< observations (priors too) minus unknowns plus rank defect
  long observation_count = 0, unknown_count = 0;  ///< coordinates (of rays that see their point); single unknowns
  int rank_defect = 0;  ///< of the datum: 7 for a free block, 0 when positions, control or fixed images fix it
  DatumSources datum;   ///< what fixes position, attitude and scale
  int iterations = 0;
  Loss tie_loss;  ///< of the rays of tie points, with the information that their residuals show
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
