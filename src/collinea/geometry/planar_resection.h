// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace collinea {

/// A direction read at a station on a horizontal circle, clockwise, to a known point of the plane (x east, y north).
struct PlanarDirection {
  Eigen::Vector2d to;
  double direction_rad = 0, sigma_rad = 1;
};

/// A station found from directions (resection of Snellius and Pothenot; Mussio 3.4.1).
struct PlanarResection {
  Eigen::Vector2d station = Eigen::Vector2d::Zero();
  double orientation_rad = 0;  ///< azimuth of the circle's zero, clockwise from y, in [0, 2 pi)
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of [station, orientation (rad)], by stated sigmas
  int redundancy = 0;
  double sigma0 = 1;                ///< 1 without redundancy
  std::vector<double> misfits_rad;  ///< read minus computed
  std::vector<double> redundancies, w;
  double danger_radius = 0;  ///< of the circle through the points (by least squares of more than three)
  double danger_off = 0;     ///< of the station off that circle: positive outside
};

/// The circle through points of the plane, by least squares of more than three: a station on it sees them under the
/// same angles from everywhere. Nothing with fewer than three, or when they lie on a line.
struct DangerCircle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;
  double points_off = 0;  ///< RMS of the points off it; 0 of three
};
[[nodiscard]] std::optional<DangerCircle> danger_circle(std::span<const Eigen::Vector2d> points);

/// Where directions leave a station open: all of them are read alike from everywhere on an arc of the circle through
/// their points.
struct OpenArc {
  DangerCircle circle;
  double from_rad = 0, to_rad = 0;  ///< seen from its centre, x towards y
  double misfit_rad = 0;            ///< root mean square of the directions there
};
/// Nothing when they are not: a misfit beyond three of its sigmas and 1e-6 rad on each arc between two points, or
/// points off the circle by more than a millionth of its radius.
[[nodiscard]] std::optional<OpenArc> open_arc(std::span<const PlanarDirection> directions);

/// By the circles of three directions in closed form (all triples, 200 at most), then least squares of all. Nothing
/// with fewer than three, when the points coincide, or when the station is on the danger circle of the points.
[[nodiscard]] std::optional<PlanarResection> planar_resection(std::span<const PlanarDirection> directions);

/// The indices of directions that contradict the least median of squares over triples (all, or 500 drawn ones): their
/// misfit at the station of those that agree is beyond 2.5 robust standard deviations and 2.5 of their own. Of n
/// directions n - [n/2] - 2 may be wrong. Nothing with fewer than five, or when those that agree leave the station
/// open.
[[nodiscard]] std::optional<std::vector<std::size_t>> contradicting_directions(
    std::span<const PlanarDirection> directions, std::uint64_t seed);

}  // namespace collinea
