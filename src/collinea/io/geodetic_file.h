// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/geodetic.h"
#include "collinea/block/gnss_vector.h"

namespace collinea {

/// One measurement on the ground as a file tells it; points by name. Of what lies on a shape `name` is that of the
/// shape, and `to` the same as `from`.
struct GeodeticFileRow {
  GeodeticKind kind = GeodeticKind::kDistance;
  std::string from, to, name, setup;
  int axis = 0;                 ///< of a line, as GeodeticObservation::axis: two rows
  double value = 0, sigma = 0;  ///< [m] or [rad]
  ControlRole role = ControlRole::kControl;
  double instrument_height_m = 0, target_height_m = 0;
  int line = 0;                ///< for messages
  GnssVector vector;           ///< of kGnssVector, which is one row
  bool is_geocentric = false;  ///< it is along the axes of the Earth
};

/// Reads measurements between points: CSV (commas, semicolons or tabs; UTF-8 or UTF-16) whose first row names the
/// columns, in any order; # starts a comment.
///     from, to                                    points, as the control file calls them; `to` may be empty where
///                                                 nothing is measured between two
///     distance_m, height_difference_m             measured; empty where not
///     direction_deg or _gon, zenith_deg or _gon   of a total station standing on `from`; zenith from 0, up, to 180
///     azimuth_deg or _gon                         clockwise from geodetic north, or from the y axis of a block without
///                                                 a location on Earth
///     dx_m, dy_m, dz_m                            a GNSS vector along the axes of the Earth (geocentric), with its
///     xx_m2, xy_m2, xz_m2, yy_m2, yz_m2, zz_m2    covariance; or
///     de_m, dn_m, du_m                            along east, north and up of the ellipsoid at `from`, with
///     ee_m2, en_m2, eu_m2, nn_m2, nu_m2, uu_m2    its covariance
///     sigma_m                                     of distance, height difference or shapes, in rows with one of them
///     sigma_distance_m, sigma_height_difference_m, sigma_direction_arcsec or _mgon, sigma_zenith_arcsec or _mgon,
///     sigma_azimuth_arcsec or _mgon
///     plane, line, level                          names of a plane, a straight line, a common height on which `from`
///                                                 lies; sigma_plane_m, sigma_line_m (on each of two axes across it),
///                                                 sigma_level_m, or sigma_m
///     name, role (control, check), setup (directions of one share an orientation; else all from one point do),
///     instrument_height_m, target_height_m        above the marks; not of height differences
/// Every measured value needs a positive sigma. Errors name the line.
[[nodiscard]] Result<std::vector<GeodeticFileRow>> read_geodetic(const std::filesystem::path& path);

/// The same, from text in memory.
[[nodiscard]] Result<std::vector<GeodeticFileRow>> parse_geodetic(std::string_view text);

}  // namespace collinea
