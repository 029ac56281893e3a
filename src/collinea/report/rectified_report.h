// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace collinea {

/// A size in the middle of an extent, and the largest at its corners.
struct Spread {
  double middle = 0, worst = 0;
};

/// A plane as it was drawn, and how good that is.
struct RectifiedReport {
  std::filesystem::path file;
  double cell_m = 0;
  int width = 0, height = 0;
  double left_m = 0, top_m = 0;
  double painted_share = 0;
  bool is_metric = true;  ///< false: the block has no scale, and "metres" are its own unit

  struct Source {
    std::string file;
    std::uint64_t cells = 0;                             ///< drawn from it
    std::optional<Eigen::Vector3d> centre_over_plane_m;  ///< where it was taken
  };
  std::vector<Source> sources;  ///< those that show anything
  /// By how much a point is shifted for each metre that it lies off the plane; nothing: where the camera stood is not
  /// known, because the view is too frontal.
  std::optional<Spread> shift_per_depth;

  struct Point {
    std::string name;
    Eigen::Vector2d residual_px, residual_m;
    double in_sigmas = 0;
  };
  /// Figures of a plane from points of one image.
  struct FromPoints {
    std::vector<Point> points;
    int redundancy = 0;
    double sigma0 = 1;                     ///< with redundancy
    bool residuals_are_too_large = false;  ///< for the sigmas stated
    Spread sigma_position_m;
    std::optional<double> focal_px, focal_sigma_px;  ///< found from the perspective
    bool is_lens_known = false;
  };
  std::optional<FromPoints> from_points;

  /// Figures of a plane of a project.
  struct FromProject {
    std::size_t points = 0, points_looked_at = 0;
    double rms_m = 0;  ///< of the points off the plane
    Eigen::Vector3d origin_on_map, origin_in_world, x_axis_in_world, y_axis_in_world, normal_in_world;
    Spread shift_by_rms_per_m;  ///< of points, for each metre of rms_m
  };
  std::optional<FromProject> from_project;
};

[[nodiscard]] std::string rectified_json(const RectifiedReport& report);
/// For a terminal, a line each; what more options would tell is left to the face.
[[nodiscard]] std::string rectified_text(const RectifiedReport& report);

}  // namespace collinea
