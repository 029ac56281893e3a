// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/geometry/rotation.h"

namespace collinea {

/// What a file says of one image. Values that are not there are empty; sigmas that are not stated are NaN.
struct PositionFileRow {
  std::string image;                          ///< path or file name
  int number = -1;                            ///< of the exposure, where the file knows no names
  std::optional<Eigen::Vector3d> geographic;  ///< latitude, longitude [deg], ellipsoidal height [m]
  std::optional<Eigen::Vector3d> in_map;      ///< easting, northing, height [m]
  Eigen::Vector3d sigma_m;                    ///< east, north, height
  std::optional<OmegaPhiKappa> angles;        ///< to the axes of the map at this position
  std::optional<AttitudePrior> attitude;      ///< the same to true north, as drones write it
  Eigen::Vector3d sigma_deg;                  ///< of turns about east, north and the plumb line
  std::string taken;                          ///< as Image::taken
  int line = 0;                               ///< for messages
};

struct PositionFile {
  std::string crs;  ///< as the file names it; may be empty
  std::vector<PositionFileRow> rows;
};

/// Reads positions and attitudes of images, one of two forms.
///
/// CSV (commas, semicolons or tabs; UTF-8 or UTF-16) whose first row names the columns, in any order; # starts a
/// comment ("# collinea positions, EPSG:32633" names the map of eastings and northings):
///     image                                        path or file name
///     latitude_deg, longitude_deg, height_m        of the antenna (or the camera), ellipsoidal; or
///     easting_m, northing_m, height_m              in the map
///     sigma_m, or sigma_plan_m, sigma_east_m, sigma_north_m, sigma_height_m
///     omega_deg, phi_deg, kappa_deg                ground = Rx Ry Rz image (x right, y up, z backward), in the map; or
///     yaw_deg, pitch_deg, roll_deg                 of an aircraft whose camera looks down with the upper edge of the
///                                                  image in front (all zero: level, nose to the north); or
///     camera_yaw_deg, camera_pitch_deg, camera_roll_deg   of the optical axis, as drones write it (pitch -90: down)
///     sigma_attitude_deg (about any axis), or those of the three angles: sigma_omega_deg, sigma_phi_deg,
///     sigma_kappa_deg; or sigma_yaw_deg, sigma_pitch_deg, sigma_roll_deg
///     taken                                        date and time, 2024:05:17 10:31:08.25 or 2024-05-17T10:31:08.25
/// An empty cell: not known; height alone may be missing.
///
/// Timestamp files of RTK drones (.mrk): number of the exposure, time of GPS, offsets from antenna to camera (north,
/// east, down [mm]), latitude, longitude and height of the camera (the manuals of the maker: after compensation; the
/// offsets are not added again), standard deviations.
///
/// Errors name the line.
[[nodiscard]] Result<PositionFile> read_positions(const std::filesystem::path& path);
[[nodiscard]] Result<PositionFile> parse_positions(std::string_view text);

}  // namespace collinea
