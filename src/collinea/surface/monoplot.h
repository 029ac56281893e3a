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

/// A ray: the point at t is centre + t direction.
struct SurfaceRay {
  Eigen::Vector3d centre, direction;
  [[nodiscard]] Eigen::Vector3d at(double t) const { return centre + t * direction; }
};

/// Between which heights a surface lies [m].
struct HeightSpan {
  double low = 0, high = 0;
};
/// Reads all of it. Errors: the raster; no heights; stopped.
[[nodiscard]] Result<HeightSpan> height_span(const HeightField& surface, const Run& run);

/// Where a ray first goes below a surface.
struct SurfaceMeeting {
  MonoplotOutcome outcome = MonoplotOutcome::kMisses;
  double t = 0;                                     ///< on the ray
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< of the surface there, by east and north
  double sigma_m = 0;                               ///< of its height; NaN: the surface states none there
};
/// The ray in the coordinates of the surface. `sigma_m`: as of monoplot(). The ray is followed piece by piece: of the
/// raster some 300 x 300 cells are held at a time, however large it is. Errors: the raster; kUnsupported, the ray
/// passes over more than kMostCellsAlongRay cells: it runs too flat.
[[nodiscard]] Result<SurfaceMeeting> meeting(const SurfaceRay& ray, const HeightField& surface, const HeightSpan& span,
                                             std::optional<double> sigma_m);
inline constexpr double kMostCellsAlongRay = 1e6;
inline constexpr double kLeastMeetingAngle_rad =
    0.0087;  ///< half a degree: an error of a height moves 115 times as far

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
/// that has no value. Cost: cells along a ray, between the lowest and the highest one of the surface. Errors: those
/// of height_span() and meeting().
[[nodiscard]] Result<std::vector<MonoplotPoint>> monoplot(std::span<const UncertainSightLine> lines,
                                                          const HeightField& surface, std::optional<double> sigma_m,
                                                          const Run& run);

}  // namespace collinea
