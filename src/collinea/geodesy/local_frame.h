// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "collinea/base/result.h"

namespace collinea {

/// Converts between the block's world frame (local: x east, y north, z up on the WGS84 ellipsoid at an origin),
/// geographic WGS84 and the coordinates of a map. The only user of PROJ. Map coordinates are always (easting, northing,
/// height) in metres, whatever the authority's axis order; geographic ones (latitude deg, longitude deg, ellipsoidal
/// height m). Heights of a plan-only CRS are ellipsoidal; those of a compound CRS ("EPSG:32633+5773") are converted by
/// its geoid. Ballpark transformations are refused; where nothing but a missing grid would do, that is an error that
/// names the grid. A LocalFrame may be used from several threads at once.
class LocalFrame {
 public:
  /// `crs`: a projected or compound CRS in metres as PROJ understands it ("EPSG:32633"). Errors: unknown CRS, not
  /// projected, not in metres, grid missing (named), lengths stretched by more than a twentieth or Web Mercator.
  static Result<LocalFrame> create(const std::string& crs, double origin_latitude_deg, double origin_longitude_deg,
                                   double origin_height_m);

  [[nodiscard]] Eigen::Vector3d local_from_map(const Eigen::Vector3d& map) const;
  [[nodiscard]] Eigen::Vector3d map_from_local(const Eigen::Vector3d& local) const;
  [[nodiscard]] Eigen::Vector3d local_from_geographic(const Eigen::Vector3d& lat_lon_height) const;
  [[nodiscard]] Eigen::Vector3d geographic_from_local(const Eigen::Vector3d& local) const;
  /// Many at once, in place; far cheaper a point than one by one.
  void local_from_map(std::span<Eigen::Vector3d> points) const;
  void map_from_local(std::span<Eigen::Vector3d> points) const;

  [[nodiscard]] const std::string& crs() const;
  [[nodiscard]] std::string wkt1() const;  ///< WKT1 (GDAL) of the CRS, for GeoTIFF
  [[nodiscard]] std::string wkt2() const;  ///< WKT2:2019, for people and other programs
  [[nodiscard]] std::string crs_name() const;

  /// The coordinate operation used between the map and WGS84, chosen once for the origin, and its accuracy by PROJ's
  /// database (nothing: unknown). Coordinates outside its domain become infinite.
  [[nodiscard]] std::string operation() const;
  [[nodiscard]] std::optional<double> accuracy_m() const;
  /// A grid that is not installed and would allow a better operation; empty: none.
  [[nodiscard]] std::string missing_grid() const;

 private:
  struct Transforms;
  std::shared_ptr<Transforms> transforms_;
};

/// The rotation from the axes of the world to those of the map (grid east, grid north, up) at a position of the world:
/// the nearest one to the derivative of the conversion.
[[nodiscard]] Eigen::Quaterniond map_from_local_rotation(const LocalFrame& frame, const Eigen::Vector3d& local);

/// The WGS84 / UTM zone of a position, "EPSG:326zz" or "EPSG:327zz".
[[nodiscard]] std::string utm_crs(double latitude_deg, double longitude_deg);

/// Geographic WGS84 (latitude deg, longitude deg, ellipsoidal height m) of map coordinates, without a local frame.
[[nodiscard]] Result<Eigen::Vector3d> geographic_from_map(const std::string& crs, const Eigen::Vector3d& map);

/// The name of a CRS, or what is wrong with it in words for the user.
[[nodiscard]] Result<std::string> check_crs(const std::string& crs);

}  // namespace collinea
