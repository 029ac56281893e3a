// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/words.h"

namespace collinea {

/// What is measured of points.
enum class FigureKind : std::uint8_t {
  kDistance,
  kPlanDistance,
  kHeightDifference,
  kSlope,
  kAngle,
  kLength,
  kArea,
  kPlanArea
};
inline constexpr Word<FigureKind> kFigureKindWords[] = {
    {FigureKind::kDistance, "distance", "between two points, in space"},
    {FigureKind::kPlanDistance, "plan_distance", "between two points, level"},
    {FigureKind::kHeightDifference, "height_difference", "of the second point above the first"},
    {FigureKind::kSlope, "slope", "of the line from the first point to the second, above the horizon"},
    {FigureKind::kAngle, "angle", "in space, at the second of three points"},
    {FigureKind::kLength, "length", "of a line through two points or more, in space"},
    {FigureKind::kArea, "area", "of a polygon of three points or more, in the plane that it spans"},
    {FigureKind::kPlanArea, "plan_area", "of a polygon of three points or more, level"}};
[[nodiscard]] constexpr std::span<const Word<FigureKind>> words(FigureKind) { return kFigureKindWords; }

/// "m", "m2" or "rad".
[[nodiscard]] std::string_view unit_of(FigureKind kind);
/// How many points a figure has: exactly so many, or at least.
struct FigureSize {
  std::size_t count = 2;
  bool is_least = false;
};
[[nodiscard]] FigureSize size_of(FigureKind kind);

/// Points to be measured: positions in a metric frame whose third axis points up, and heights where these are counted
/// from something curved (the ellipsoid, the geoid); empty: the third coordinates.
struct FigurePoints {
  std::vector<Eigen::Vector3d> positions;  ///< [m]
  std::vector<double> heights = {};        ///< [m]
  Eigen::MatrixXd covariance = {};         ///< of all positions together, 3 rows each [m^2]; empty: they are exact
};

struct MeasuredFigure {
  double value = 0, sigma = 0;  ///< in unit_of()
};

/// Measures a figure of some of the points, by their numbers, and its standard deviation by the covariance of all of
/// them: what points have in common, such as the position of the block, is not in a distance. Level distances are
/// reduced by the heights, d^2 = distance^2 - difference^2. Lengths are those on the ground, not of a map. First-order
/// propagation. Errors: kBadInput (another count of points, a number that there is not), kIllPosed (points that
/// coincide, an area of nothing, a level line of which is asked how level it is).
[[nodiscard]] Result<MeasuredFigure> measure_figure(FigureKind kind, std::span<const std::size_t> numbers,
                                                    const FigurePoints& points);

}  // namespace collinea
