// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "collinea/assess/internal/difference_statistics.h"
#include "collinea/base/run.h"
#include "collinea/base/words.h"
#include "collinea/surface/height_field.h"

namespace collinea {

/// By what a surface is brought to its reference before they are compared.
enum class Coregistration { kNone, kShift, kSimilarity };
inline constexpr Word<Coregistration> kCoregistrationWords[] = {
    {Coregistration::kNone, "none"},
    {Coregistration::kShift, "shift", "east, north, up"},
    {Coregistration::kSimilarity, "similarity", "turns and scale too"}};
[[nodiscard]] constexpr std::span<const Word<Coregistration>> words(Coregistration) { return kCoregistrationWords; }

/// How a surface lies against its reference: its point is R m (X - middle) + middle + shift of the reference's point X.
struct SurfaceShift {
  int unknowns = 0;  ///< 3: the shift alone; 7: turns and scale too
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  /// East, north, up [m]; turns about these axes [rad]; scale less 1.
  Eigen::Matrix<double, 7, 1> values = Eigen::Matrix<double, 7, 1>::Zero();
  /// By the scatter of the differences, as though these were independent of each other.
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
  double sigma0_m = 0;
  std::size_t used = 0, left_out = 0;  ///< differences; those beyond three robust standard deviations were left out
  int iterations = 0;
};

/// Points of a reference, batch by batch; an empty batch ends it. It can be begun again from the start.
using ReferencePoints = std::function<Result<std::vector<Eigen::Vector3d>>(bool from_start)>;

/// The points of a reference that is a grid: the middles of its cells that have a height, tile by tile.
[[nodiscard]] ReferencePoints points_of_grid(const HeightField& reference);

/// The co-registration of a surface and its reference by least squares of the differences of heights (Ebner and
/// Strunz, ISPRS 27-III, 1988; Rosenholm and Torlegard, PE&RS 54, 1988): for the reference's point X and the surface
/// F with slopes Fx, Fy
///     v = Fx dx + Fy dy - dz + F(x, y) - z
/// at the point as it is moved so far; dx, dy, dz of the three shifts or of a small similarity about the middle of the
/// points. At most 60,000 points, spread evenly over the reference, none where the surface is steeper than 45 degrees
/// (walls); differences beyond three robust standard deviations
/// are left out, again in each iteration. Errors: fewer than 30 points on the surface; a surface too level to fix the
/// shifts in plan (standard deviation above ten cells); reading; no convergence.
[[nodiscard]] Result<SurfaceShift> coregister(const HeightField& surface, const ReferencePoints& reference,
                                              Coregistration kind);

/// What is compared beyond the heights.
struct ComparisonOptions {
  double tolerance_m = 0;  ///< sigma of a difference; 0: nmad of the differences themselves
  /// Class of a cell by its position on the map, such as measured or interpolated; null: none.
  std::function<Result<int>(const Eigen::Vector2d& on_map)> class_at = {};
};

/// Differences of heights, surface less reference, after the shift is taken off.
struct HeightComparison {
  double tolerance_m = 0;
  bool tolerance_from_data = false;
  DifferenceStatistics all;
  std::array<DifferenceStatistics, 5> by_slope;                ///< of the surface, see kSlopeLimits_deg
  std::vector<std::pair<int, DifferenceStatistics>> by_class;  ///< ascending
  std::size_t without_height = 0;                              ///< points where the surface has nothing
  /// Of the surface's own standard deviations, where it has any: the mean square of difference over sigma, and the
  /// share below 1.96.
  std::optional<double> variance_ratio, within_bounds;
};
inline constexpr std::array<double, 4> kSlopeLimits_deg = {5, 15, 30, 45};

/// Compares at every point of the reference. `take` (may be null) gets each point of the surface with its difference.
/// Errors: no point of the reference lies on the surface; reading; cancelled.
[[nodiscard]] Result<HeightComparison> compare_heights(
    const HeightField& surface, const ReferencePoints& reference, const SurfaceShift& shift,
    const ComparisonOptions& options, const Run& run,
    const std::function<void(const Eigen::Vector3d& on_map, double difference_m)>& take = {});

/// The standard deviation [m] of a height measured in a vertical pair (normal case): k (H / B) sigma of a parallax in
/// the photograph, k = scale number = H / c.
[[nodiscard]] inline double normal_case_sigma_m(double scale_number, double height_over_base, double sigma_image_m) {
  return scale_number * height_over_base * sigma_image_m;
}

/// The standard deviation [m] of the difference between a height and that of an independent reference (Karfis 8.2).
[[nodiscard]] inline double difference_sigma_m(double sigma_m, double sigma_reference_m) {
  return std::hypot(sigma_m, sigma_reference_m);
}

}  // namespace collinea
