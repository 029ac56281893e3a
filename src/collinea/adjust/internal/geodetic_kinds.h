// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <tuple>

#include "collinea/adjust/unknowns.h"
#include "collinea/block/geodetic.h"

// The kinds of geodetic measurements and constraints, one for each GeodeticKind: the computed value and its
// derivatives. Each is in the file of its name. A new one is its file, a struct here and its entry in the closed list
// at the end, a GeodeticKind and an ObservationGroup. Earth says where up and north are.

namespace collinea {

/// Where up and north are in the world.
struct Earth {
  /// The z axis of the world is the plumb line at its origin and the Earth is a sphere there, of mean radius; otherwise
  /// z is up everywhere.
  bool is_round = false;
  Eigen::Vector3d pole = Eigen::Vector3d::UnitY();  ///< axis of the Earth, northwards: north is what of it is level
  /// By which the plumb line points north and east of the normal of a round Earth; heights count across it.
  Eigen::Vector2d deflection_rad = Eigen::Vector2d::Zero();
};

/// A measurement on the ground as points and unknowns of its own predict it, with its derivatives.
struct GeodeticModel {
  double computed = 0;                                                                 ///< [m] or [rad]
  Eigen::Vector3d by_from = Eigen::Vector3d::Zero(), by_to = Eigen::Vector3d::Zero();  ///< [1] or [rad/m]
  std::array<double, 3> by_auxiliary{};  ///< unknowns of its own: orientation of the set-up, or of a shape
  int auxiliaries = 0;                   ///< how many of them
};

/// Where a shape that points lie on begins: a frame of three axes in the world, seen from which it is described.
struct GeodeticShape {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< by columns; of a plane the last is the normal, of a line:
                                                       ///< sideways, upwards, along it
};

namespace geodetic {

/// What a measurement sees of its two points.
struct Sight {
  const GeodeticObservation& observation;
  Eigen::Vector3d from, to;      ///< the points
  Eigen::Vector3d up, up_there;  ///< at each
  Eigen::Vector3d line;          ///< from the instrument to the target
  double orientation_rad = 0;    ///< azimuth of zero of the horizontal circle
  Earth earth;
};

/// Slope distance between instrument and target [m].
struct Distance {
  static constexpr GeodeticKind kKind = GeodeticKind::kDistance;
  static GeodeticModel model(const Sight& sight);
};

/// Height of the second point over the first [m].
struct HeightDifference {
  static constexpr GeodeticKind kKind = GeodeticKind::kHeightDifference;
  static GeodeticModel model(const Sight& sight);
};

/// Horizontal direction, clockwise from zero of the circle [rad]. Unknown of its own: the orientation of the set-up.
struct Direction {
  static constexpr GeodeticKind kKind = GeodeticKind::kDirection;
  static GeodeticModel model(const Sight& sight);
};

/// Angle between the plumb line and the line of sight [rad]; with refraction (k = 0.13) where the Earth is curved.
struct ZenithAngle {
  static constexpr GeodeticKind kKind = GeodeticKind::kZenithAngle;
  static GeodeticModel model(const Sight& sight);
};

/// Azimuth of the line of sight, clockwise from north at the instrument [rad]. North turns with the convergence of
/// meridians where the Earth is round.
struct Azimuth {
  static constexpr GeodeticKind kKind = GeodeticKind::kAzimuth;
  static GeodeticModel model(const Sight& sight);
};

/// Part of the vector between the antennas along a direction that is known [m].
struct GnssVector {
  static constexpr GeodeticKind kKind = GeodeticKind::kGnssVector;
  static GeodeticModel model(const Sight& sight);
};

/// A point that lies on a shape, and what describes the shape against its frame.
struct ShapePoint {
  const GeodeticObservation& observation;
  const GeodeticShape& shape;
  const double* unknowns;
  Eigen::Vector3d point;
  Earth earth;

  [[nodiscard]] Eigen::Vector3d local() const { return shape.axes.transpose() * (point - shape.origin); }
};

/// How the points of a shape spread around their mean: squared lengths ascending, with their directions by columns.
struct ShapeSpread {
  Eigen::Vector3d length2;
  Eigen::Matrix3d directions;

  /// The longest, upwards.
  [[nodiscard]] Eigen::Vector3d along() const;
};

/// A point at a height that it has in common with others [m]. Unknown: the height.
struct CommonHeight {
  static constexpr GeodeticKind kKind = GeodeticKind::kAtHeight;
  static constexpr UnknownKind kUnknown = UnknownKind::kHeight;
  static constexpr int kUnknowns = 1, kPoints = 1;
  static GeodeticModel model(const ShapePoint& at);
};

/// A point on a plane [m]. Unknowns: the offset along the normal of the frame and two tilts.
struct OnPlane {
  static constexpr GeodeticKind kKind = GeodeticKind::kOnPlane;
  static constexpr UnknownKind kUnknown = UnknownKind::kPlane;
  static constexpr int kUnknowns = 3, kPoints = 3;
  static GeodeticModel model(const ShapePoint& at);
  /// The axes of the plane's frame; nothing where the points lie on a line.
  static std::optional<Eigen::Matrix3d> axes(const ShapeSpread& spread);
};

/// A point on a line, sideways or upwards of it (GeodeticObservation::axis) [m]. Unknowns: two offsets and two tilts.
struct OnLine {
  static constexpr GeodeticKind kKind = GeodeticKind::kOnLine;
  static constexpr UnknownKind kUnknown = UnknownKind::kLine;
  static constexpr int kUnknowns = 4, kPoints = 2;
  static GeodeticModel model(const ShapePoint& at);
  static std::optional<Eigen::Matrix3d> axes(const ShapeSpread& spread);
};

/// The closed list: what is measured between two points, and the shapes that points lie on.
using SightKinds = std::tuple<Distance, HeightDifference, Direction, ZenithAngle, Azimuth, GnssVector>;
using ShapeKinds = std::tuple<CommonHeight, OnPlane, OnLine>;
static_assert(std::tuple_size_v<SightKinds> + std::tuple_size_v<ShapeKinds> == kGeodeticKinds);

/// Calls visit.operator()<Kind>() for the struct of a kind, if the list has it.
template <class Kinds, class Visit>
constexpr void visit_kind(GeodeticKind kind, Visit&& visit) {
  [&]<class... Kind>(const std::tuple<Kind...>*) {
    ((Kind::kKind == kind ? visit.template operator()<Kind>() : void()), ...);
  }(static_cast<const Kinds*>(nullptr));
}

/// Radius of the Earth, a sphere [m].
inline constexpr double kEarthRadius_m = 6371000;

/// The normal of the Earth at a point, the plumb line there, both upwards, and the height of the point above the level
/// of the origin of the world.
[[nodiscard]] Eigen::Vector3d normal_at(const Eigen::Vector3d& point, const Earth& earth);
[[nodiscard]] Eigen::Vector3d up_at(const Eigen::Vector3d& point, const Earth& earth);
[[nodiscard]] double height_of(const Eigen::Vector3d& point, const Earth& earth);

/// Sets both derivatives of a value that depends on the line of sight alone.
void derive_by_line(GeodeticModel& model, const Eigen::Vector3d& derivative);

}  // namespace geodetic
}  // namespace collinea
