// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace collinea {

/// A plane with its own frame: x to the right and y up as seen from the front, z (the normal) to the viewer.
struct FramedPlane {
  Eigen::Vector3d origin_in_world;
  Eigen::Matrix3d world_from_plane;  ///< a rotation; its columns are the axes

  [[nodiscard]] Eigen::Vector3d in_plane(const Eigen::Vector3d& point_in_world) const {
    return world_from_plane.transpose() * (point_in_world - origin_in_world);
  }
};

/// The axes of a plane through `origin_in_world` whose front is on the side of `normal_in_world`: y is the direction of
/// steepest ascent along `up_in_world`, of a plane within 10 degrees of level the projected y axis of the world
/// (north).
[[nodiscard]] FramedPlane framed_plane(const Eigen::Vector3d& origin_in_world, const Eigen::Vector3d& normal_in_world,
                                       const Eigen::Vector3d& up_in_world = Eigen::Vector3d::UnitZ());

struct PlaneFit {
  Eigen::Vector3d middle, normal;   ///< of unit length, to either side
  double rms_m = 0;                 ///< of the distances of the points that were used
  std::vector<std::size_t> points;  ///< those used
};

/// The plane that minimises the squared distances of three points or more. Nothing when they lie on a line: the middle
/// extent of the points is below a thousandth of the largest.
[[nodiscard]] std::optional<PlaneFit> fit_plane(std::span<const Eigen::Vector3d> points);

/// The plane that most points lie on within `tolerance_m`: random samples of three (seed), then least squares over its
/// points, twice. Nothing when less than a tenth of the points lie on any.
[[nodiscard]] std::optional<PlaneFit> find_plane(std::span<const Eigen::Vector3d> points, double tolerance_m,
                                                 std::uint64_t seed);

}  // namespace collinea
