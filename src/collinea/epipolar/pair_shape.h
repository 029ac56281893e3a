// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/relative_elements.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// What in the shape of an object or of a pair weakens its relative orientation.
enum class PairWeakness : std::uint8_t {
  kCylinder,
  kNearCylinder,
  kPlane,
  kBasePlane,
  kNarrow,
  kShortBase,
  kNearPlane
};
inline constexpr Word<PairWeakness> kPairWeaknessWords[] = {
    {PairWeakness::kCylinder, "cylinder", "points and base lie on a cylinder (a critical surface)"},
    {PairWeakness::kNearCylinder, "near_cylinder", "points and base lie near a cylinder (a critical surface)"},
    {PairWeakness::kPlane, "plane", "the points lie in a plane: a second orientation fits them as well, or nearly"},
    {PairWeakness::kBasePlane, "base_plane", "the points lie in one plane with the base"},
    {PairWeakness::kNarrow, "narrow",
     "the points lie near one plane with the base (a critical surface), in a narrow band along it"},
    {PairWeakness::kShortBase, "short_base", "the rays are nearly parallel: the base is short"},
    {PairWeakness::kNearPlane, "near_plane", "the points lie near a plane: a second orientation fits them nearly"}};
[[nodiscard]] constexpr std::span<const Word<PairWeakness>> words(PairWeakness) { return kPairWeaknessWords; }

/// The cylinder along the base that fits the points best: its axis is parallel to the base, which lies on it. Lengths
/// in units of the base. Seen along the base it is a circle (Mussio 3.4.2).
struct CriticalCylinder {
  Eigen::Vector2d centre;  ///< of the circle, from the base, along across_in_first
  double radius = 0;
  double roughness = 0;  ///< RMS distance of the points from it (sigma_delta, Mussio 3.4.3)
};

/// The geometry of a pair, as far as it determines its relative orientation.
struct PairShape {
  int points = 0;                               ///< in front of both cameras
  Eigen::Matrix<double, 3, 2> across_in_first;  ///< axes across the base: second one as near as possible to the points
  double distance = 0;                          ///< mean distance of the points from the base, in bases
  double width = 0;                             ///< extent of the points along the base, in bases
  double breadth = 0;                        ///< standard deviation of the direction to the points about the base [rad]
  double median_angle_rad = 0;               ///< under which rays meet
  std::optional<CriticalCylinder> cylinder;  ///< nothing when points and base lie in a plane
  double plane_roughness = 0;  ///< RMS distance of the points from the plane that fits them best, in bases
  Eigen::Vector3d plane_normal = {0, 0, 1}, plane_middle = {0, 0, 0};  ///< of that plane, in the first camera, in bases
  double plane_sigma = 0;           ///< the same as measurements of their sigmas would leave of a true plane
  double base_plane_roughness = 0;  ///< the same of a plane through the base
  Eigen::Vector2d base_plane_direction = {0, 1};  ///< of that plane, from the base, along across_in_first
  double epsilon_raw = 0;  ///< lambda_min / lambda_max of the normal matrix of by, bz, omega, phi, kappa (1, rad)
  double epsilon = 0;      ///< the same, scaled to a unit diagonal (Mussio 3.4.5): 1 ideal, 0 undetermined
  Vector5 null_vector = Vector5::Zero();  ///< of the smaller one: by, bz, omega, phi, kappa, each in units of its sigma
                                          ///< with the others known; the largest is 1
  bool of_elements = true;                ///< false: the base has no x component, and the figures are of changed()
  double inflation = 1;                   ///< by which not knowing the others enlarges the worst sigma of the five
  std::vector<PairWeakness> weaknesses;
};

/// Judges the pair. `normal` is that of changed(), RelativeOrientation::normal. Nothing with fewer than five points in
/// front of both cameras.
/// A cylinder is near when its roughness is below 5 % of the distance, and critical below 1 %, or where epsilon is
/// below 1e-9; a plane is near below 5 %, too. A plane with the base is near where the band is narrow: seen from the
/// base they are one. (Mussio's limit of 0.1 for lambda_min / lambda_max is out of reach of flat ground at any angle of
/// view: even his own six points want a roughness of 65 % of the distance for it; both figures are given.)
[[nodiscard]] std::optional<PairShape> pair_shape(const Rigid3& second_from_first, std::span<const PairPoint> points,
                                                  const Matrix5& normal);

/// The normal matrix of changed() of such points with that motion, weights by their sigmas.
[[nodiscard]] Matrix5 normal_of(const Rigid3& second_from_first, std::span<const PairPoint> points);

}  // namespace collinea
