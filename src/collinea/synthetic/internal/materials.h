// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "collinea/synthetic/internal/colour.h"
#include "collinea/synthetic/internal/solid.h"

namespace collinea {

/// A road painted on the terrain: a band of constant width about the sine curve
/// v = offset + amplitude sin(2 pi u / wavelength) in axes turned by the direction (cosine, sine); and again every
/// repeat_m of v, when that is positive.
struct Road {
  double cosine = 1, sine = 0;
  double offset_m = 0, amplitude_m = 0, wavelength_m = 100, half_width_m = 3;
  double repeat_m = 0;

  /// Distance from the (nearest) middle line (to first order in its curvature) and the distance along it [m].
  [[nodiscard]] Eigen::Vector2d off_and_along(double x, double y) const;
  /// The slope dv/du of the middle line there.
  [[nodiscard]] double slope_at(double along_m) const;
  /// The position `off_m` beside the middle line of the road that is the `number`-th of those repeated.
  [[nodiscard]] Eigen::Vector2d position(double off_m, double along_m, int number) const;
};

/// How the terrain is painted.
struct Ground {
  enum class Kind : std::uint8_t { kFields, kPaving, kRocks };
  Kind kind = Kind::kFields;
  double field_m = 38;    ///< mean size of a field
  double district_m = 0;  ///< size of the largest parts of brighter and darker land; 0: none
  std::vector<Road> roads;
  std::uint32_t seed = 0;
};

/// A survey mark: a white board with two black quarters that meet at its centre.
struct Mark {
  Eigen::Vector3d centre, right, up;  ///< right and up: unit vectors in the board's plane
  double half_size_m = 0.2;
};

/// The reflectance of the ground at a point, averaged over about `footprint_m`.
[[nodiscard]] Colour ground_albedo(const Ground& ground, double x, double y, double footprint_m);

/// The reflectance of a face of a body at a point on it.
[[nodiscard]] Colour solid_albedo(const Solid& solid, int face, const Eigen::Vector3d& point, double footprint_m);

/// The reflectance of a surface that carries the mark, where `beneath` is that of the surface itself.
[[nodiscard]] Colour mark_albedo(const Mark& mark, const Eigen::Vector3d& point, double footprint_m, Colour beneath);

}  // namespace collinea
