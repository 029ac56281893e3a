// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/camera/camera.h"
#include "collinea/geometry/polygon.h"
#include "collinea/io/map_area.h"

namespace collinea {

/// The flight that is planned. Plan coordinates are those of the map, east and north [m]; heights count from the
/// ground.
struct FlightOptions {
  std::optional<double> east_m = {}, north_m = {};
  double west_m = 0, south_m = 0;
  int width_px = 5280, height_px = 3956;
  double focal_mm = 12.29, sensor_width_mm = 17.3;
  double gsd_m = 0.02;
  std::optional<double> height_m = {};
  double forward_overlap = 0.8, side_overlap = 0.7;
  std::optional<double> heading_deg = {};
  double tilt_deg = 0;
  int cross_strips = 0;
  double cross_height = 1.15;
  double relief_m = 0;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = FlightOptions;
    visit(Field{"east_m", &O::east_m, "m", "extent of the site to the east, when it is a rectangle", 1, 1e6});
    visit(Field{"north_m", &O::north_m, "m", "extent of the site to the north", 1, 1e6});
    visit(Field{"west_m", &O::west_m, "m", "easting of its south-western corner"});
    visit(Field{"south_m", &O::south_m, "m", "northing of its south-western corner"});
    visit(Field{"width_px", &O::width_px, "px", "width of the images, across the flight", 64, 100000});
    visit(Field{"height_px", &O::height_px, "px", "height of the images, along the flight", 64, 100000});
    visit(Field{"focal_mm", &O::focal_mm, "mm", "focal length", 0.1, 10000});
    visit(Field{"sensor_width_mm", &O::sensor_width_mm, "mm",
                "width of the sensor; 36 where focal_mm is the 35 mm equivalent", 0.1, 1000});
    visit(Field{"gsd_m", &O::gsd_m, "m", "size of a pixel on the ground; not used when height_m is given", 1e-4, 10});
    visit(Field{"height_m", &O::height_m, "m", "flying height above ground; nothing: from gsd_m", 1, 20000});
    visit(Field{"forward_overlap", &O::forward_overlap, "1", "overlap along a strip", 0.0, 0.98});
    visit(Field{"side_overlap", &O::side_overlap, "1", "overlap of neighbouring strips", 0.0, 0.98});
    visit(Field{"heading_deg", &O::heading_deg, "deg",
                "of the first strip, clockwise from north; nothing: that which needs the fewest strips", -360, 360});
    visit(Field{"tilt_deg", &O::tilt_deg, "deg", "by which the camera looks forward from straight down", 0, 60});
    visit(Field{"cross_strips", &O::cross_strips, "1",
                "strips across the others: one in the middle, more spread from end to end", 0, 1000});
    visit(Field{"cross_height", &O::cross_height, "1", "their flying height over that of the others", 0.5, 2});
    visit(Field{"relief_m", &O::relief_m, "m",
                "range of the heights of the ground; 0: flat, which tells least of the camera", 0, 5000});
  }
};

/// Plan coordinates along a heading (clockwise from north) and to the right of it.
struct StripAxes {
  Eigen::Vector2d along, across;

  explicit StripAxes(double heading_rad);
  [[nodiscard]] Eigen::Vector2d uv(const Eigen::Vector2d& position) const {
    return {along.dot(position), across.dot(position)};
  }
  [[nodiscard]] Eigen::Vector2d position(double u, double v) const { return u * along + v * across; }
};

/// One planned exposure.
struct PlannedImage {
  int strip = 0;
  bool cross = false;
  Eigen::Vector3d centre;  ///< plan coordinates, height above ground [m]
  double heading_rad = 0;  ///< clockwise from north: where the upper edge of the image points
};

struct FlightPlan {
  MapArea area;
  Camera camera;
  double height_m = 0, gsd_m = 0;
  double across_m = 0, along_m = 0;  ///< an image on the ground, straight down
  double base_m = 0, spacing_m = 0;
  double heading_rad = 0, tilt_rad = 0;
  double relief_m = 0;
  int strips = 0, cross_strips = 0;
  double path_m = 0;  ///< of all strips and the ways between them
  std::vector<PlannedImage> images;
};

/// Strips over the area and, at the same overlap, strips across. The outermost axes and the first and last exposure of
/// each strip lie on the border or up to half a step beyond it. `area`: empty: the rectangle of the options. Errors:
/// options out of range; no area, or one without extent; more than 20,000 images; a camera that sees the horizon.
[[nodiscard]] Result<FlightPlan> plan_flight(const FlightOptions& options, const MapArea& area);

}  // namespace collinea
