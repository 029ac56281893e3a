// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/file_text.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

/// Titles of the columns of our CSV, for those who write one; the reader does not need them.
inline constexpr FileText kControlPointColumns =
    "point, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role";
inline constexpr FileText kControlImageColumns = "image, id, file, x_px, y_px, sigma_px";

/// What is assumed of rows that state no standard deviation.
struct ControlDefaults {
  double sigma_plan_m = 0.02;
  double sigma_height_m = 0.03;
  double sigma_px = 0.5;
};

/// A surveyed point as a file tells it. An axis that was not surveyed has an infinite sigma; its coordinate is then the
/// mean of the other points' (0 when there is none), so that conversions between frames stay sound.
struct ControlFilePoint {
  std::string name;
  Eigen::Vector3d position_in_map;  ///< easting, northing, height [m]
  Eigen::Vector3d sigma_m;          ///< east, north, height
  ControlRole role = ControlRole::kControl;
  Eigen::Vector3d correlation = Eigen::Vector3d::Zero();  ///< as ControlPoint::correlation
};

/// A surveyed point seen in an image.
struct ControlFileObservation {
  std::string point;  ///< the name of one of the points
  std::string file;   ///< the image, as the control file calls it: usually without its folder
  Eigen::Vector2d pixel;
  double sigma_px = 0.5;
  int line = 0;  ///< of the control file, for messages
};

struct ControlFile {
  std::string crs;                                   ///< what PROJ understands; empty: the file states none
  std::vector<ControlFilePoint> points;              ///< in the order of the file, names differ
  std::vector<ControlFileObservation> observations;  ///< in the order of the file
};

/// Reads surveyed points and where they are seen in images. Two formats, recognised by content:
///
/// OpenDroneMap's gcp_list.txt. The first line is the CRS ("EPSG:32617", "WGS84 UTM 17N", "+proj=utm ..."), then
///     x y z column row image [name]
/// between white space (or tabs, when names hold blanks); z may be NaN or left out. Rows with one name, or without
/// names with one x y z, are one point. In files in degrees (EPSG:4326) x is the longitude and y the latitude; they
/// come back in the UTM zone of their first point, heights unchanged.
///
/// Our CSV. Rows start with a word; rows without any number are titles; # starts a comment:
///     # collinea control, EPSG:32633
///     point, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role
///     image, id, file, x_px, y_px, sigma_px
///     covariance, id, ee_m2, en_m2, eh_m2, nn_m2, nh_m2, hh_m2
/// Role is control (default) or check. Sigmas may all be left out: `defaults`. `inf`, or an empty field beside given
/// sigmas, or an empty coordinate, means that the axis was not surveyed; a point may have none of the three. sigma_px
/// may be left out. A covariance stands below its point and in place of its sigmas; fields of an axis that was not
/// surveyed are empty.
///
/// Both count pixels from the outer corner of the picture, as we do. Errors name the line.
[[nodiscard]] Result<ControlFile> read_control(const std::filesystem::path& path, const ControlDefaults& defaults = {});

/// The same, from text in memory.
[[nodiscard]] Result<ControlFile> parse_control(std::string_view text, const ControlDefaults& defaults = {});

/// Makes the named points check points, and all others control points. Errors: there is no point of such a name.
[[nodiscard]] Result<> set_check_points(ControlFile& control, std::span<const std::string> names);

/// The CRS that a line of an OpenDroneMap file means, as PROJ understands it; empty when it is not a CRS.
[[nodiscard]] std::string normalised_crs(std::string_view text);

}  // namespace collinea
