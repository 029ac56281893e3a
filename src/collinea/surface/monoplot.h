// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/epipolar/oriented_intersection.h"
#include "collinea/surface/height_field.h"

namespace collinea {

/// What became of a ray.
enum class MonoplotOutcome : std::uint8_t { kFound, kMisses, kHole, kBelow, kGrazes };
inline constexpr Word<MonoplotOutcome> kMonoplotOutcomeWords[] = {
    {MonoplotOutcome::kFound, "found", "the ray meets the surface"},
    {MonoplotOutcome::kMisses, "misses", "the ray does not meet the surface within the raster"},
    {MonoplotOutcome::kHole, "hole", "the ray goes below the surface where the raster has no heights"},
    {MonoplotOutcome::kBelow, "below", "the ray is below the surface where it enters the raster"},
    {MonoplotOutcome::kGrazes, "grazes", "the ray runs along the surface (below half a degree): no position"}};
[[nodiscard]] constexpr std::span<const Word<MonoplotOutcome>> words(MonoplotOutcome) { return kMonoplotOutcomeWords; }

/// Where the ray of an image point meets a surface.
struct MonoplotPoint {
  MonoplotOutcome outcome = MonoplotOutcome::kMisses;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of image point, orientation and height [m^2]
  double height_sigma_m = 0;  ///< of the surface there, that the covariance holds; NaN: the surface states none there
  double angle_rad = 0;       ///< between ray and surface
};

/// Monoplotting (Mussio; Karfis 6.3): ground points from one oriented image and a surface of heights. The surface is
/// bilinear between the middles of its cells, and the ray is followed from the camera to where it first goes below it.
/// With d the direction of the ray, t the distance and n = (-h_x, -h_y, 1) the normal of the surface (slopes over 3 x 3
/// cells), a change of the ray moves what it passes by  dX = t dd + dC  and the point by  (I - d n'/n.d) dX;  an error
/// e of the height by  d e / n.d.  Nothing is assumed of how errors of neighbouring heights depend on each other.
/// `sigma_m`: of heights whose raster states none; nothing: exact where there is no raster of sigmas, unknown where
/// that has no value. Cost: cells under a ray, between the lowest and the highest one of the surface. Errors: the
/// raster.
[[nodiscard]] Result<std::vector<MonoplotPoint>> monoplot(std::span<const UncertainSightLine> lines,
                                                          const HeightField& surface, std::optional<double> sigma_m,
                                                          const Run& run);

}  // namespace collinea
