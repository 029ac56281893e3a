// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <string>

#include "collinea/base/id.h"

namespace collinea {

/// What is measured on the ground between two points, or known of the shape that a point lies on.
enum class GeodeticKind : std::uint8_t {
  kDistance,          ///< in space, tape, scale bar or total station [m]
  kHeightDifference,  ///< height of `to` minus that of `from` [m]; 0 for equal heights
  kDirection,         ///< reading of the horizontal circle at `from`, clockwise [rad]
  kZenithAngle,       ///< at `from`, 0 upwards [rad]
  kAtHeight,          ///< `from` above the height that the points of a group have in common [m]
  kOnPlane,           ///< `from` off the plane of a group [m]
  kOnLine,            ///< `from` off the line of a group, across it on one of two axes [m]
  kAzimuth,           ///< at `from`, clockwise from geodetic north; without a location on Earth from the y axis [rad]
  kGnssVector,        ///< part of the vector from `from` to `to` along a direction [m]; see block/gnss_vector.h
};
inline constexpr std::size_t kGeodeticKinds = 9;
inline constexpr std::array<const char*, kGeodeticKinds> kGeodeticKindNames = {
    "distance", "height difference", "direction", "zenith angle", "height", "plane", "line", "azimuth", "GNSS vector"};

enum class ControlRole { kControl, kCheck };

/// One measurement between two control points, which need no coordinates of their own; or that `from` (and `to`, which
/// is the same) lies on a shape.
struct GeodeticObservation {
  static constexpr std::uint32_t kNoSetup = ~std::uint32_t{0};

  GeodeticKind kind = GeodeticKind::kDistance;
  std::string name;  ///< as its file calls it; may be empty
  ControlId from, to;
  double value = 0, sigma = 0;               ///< [m], or [rad] for angles
  ControlRole role = ControlRole::kControl;  ///< kCheck: only compared
  /// Directions of one set-up of the instrument share its orientation, points of one shape share that; shapes of one
  /// kind have different numbers. Three parts of one GNSS vector have its number.
  std::uint32_t setup = kNoSetup;
  double instrument_height_m = 0, target_height_m = 0;  ///< above the marks
  int axis =
      0;  ///< of kOnLine: 0 sideways (east off a plumb line), 1 upwards (north off a plumb line); of a vector 0-2
  /// Of kGnssVector: the direction, a unit vector in the world or, `is_local`, along east, north and up of the
  /// ellipsoid at `from`.
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  bool is_local = false;

  [[nodiscard]] bool is_angle() const {
    return kind == GeodeticKind::kDirection || kind == GeodeticKind::kZenithAngle || kind == GeodeticKind::kAzimuth;
  }
  [[nodiscard]] bool is_of_shape() const { return kind >= GeodeticKind::kAtHeight && kind <= GeodeticKind::kOnLine; }
};

}  // namespace collinea
