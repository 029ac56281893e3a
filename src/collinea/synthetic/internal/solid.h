// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "collinea/synthetic/internal/colour.h"

namespace collinea {

/// What a face is covered with; all of it is matte.
enum class Finish : std::uint8_t {
  kPlain,
  kTiles,
  kGravelRoof,
  kHouseWall,
  kPlaster,
  kBrick,
  kStone,
  kWindow,
  kLeaves
};

/// A convex body that stands upright: a box, a house with a gabled roof whose ridge runs along its length, a column, or
/// the crown of a tree: an ellipsoid that is round in plan.
struct Solid {
  enum class Shape : std::uint8_t { kBox, kGable, kColumn, kCrown };
  enum Face : int { kEnd = 0, kOtherEnd = 1, kSide = 2, kOtherSide = 3, kBottom = 4, kRoof = 5, kOtherRoof = 6 };

  Shape shape = Shape::kBox;
  double x = 0, y = 0;                           ///< centre in plan
  double cosine = 1, sine = 0;                   ///< of the direction of its length against x
  double half_length_m = 1, half_width_m = 1;    ///< the radius of what is round is half_length_m
  double bottom_m = 0, eave_m = 1, ridge_m = 1;  ///< heights; ridge = eave but for a gable
  Finish wall = Finish::kPlain, roof = Finish::kPlain;
  Colour wall_colour{0.5f, 0.5f, 0.5f}, roof_colour{0.4f, 0.4f, 0.4f};
  std::uint32_t seed = 0;

  [[nodiscard]] bool is_round() const { return shape == Shape::kColumn || shape == Shape::kCrown; }
  /// Half the diagonal of the plan, or its radius [m].
  [[nodiscard]] double radius_m() const;
};

struct SolidHit {
  double t;
  int face;
};

/// Where the line origin + t direction enters the body, when t > 0; lines that start inside do not.
[[nodiscard]] std::optional<SolidHit> meet(const Solid& solid, const Eigen::Vector3d& origin,
                                           const Eigen::Vector3d& direction);

/// The outward unit normal of a face at a point on it.
[[nodiscard]] Eigen::Vector3d normal_of(const Solid& solid, int face, const Eigen::Vector3d& point);

/// The height of the body's upper face over a position; nothing beside it.
[[nodiscard]] std::optional<double> top_at(const Solid& solid, double x, double y);

/// Coordinates on a face for its texture [m]: along the wall and up, or along the ridge and down the slope.
[[nodiscard]] Eigen::Vector2d face_coordinates(const Solid& solid, int face, const Eigen::Vector3d& point);

}  // namespace collinea
