// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>

#include "collinea/report/internal/svg.h"

namespace collinea {

inline constexpr double kMapWidth = 940, kMapMargin = 34;  ///< [px]

/// Plan coordinates to pixels: the same scale on both axes, north up.
struct MapView {
  Eigen::Vector2d low, high;
  double pixels_per_unit = 1, width = 0, height = 0;
  double footer = 0;  ///< room below the map for scale and legend

  MapView(const Eigen::Vector2d& lowest, const Eigen::Vector2d& highest, double wanted_width, double most_height);
  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector2d& plan) const;
  [[nodiscard]] Eigen::Vector2d operator()(const Eigen::Vector3d& world) const {
    return (*this)(Eigen::Vector2d(world.head<2>()));
  }
};

class MapBounds {
 public:
  void add(const Eigen::Vector2d& p);
  [[nodiscard]] MapView view(double width, double most_height) const;

 private:
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()), high_ = -low_;
};

/// A round length in the unit it is read in: "5 mm", "2 km".
[[nodiscard]] std::string scale_text(double length, const std::string& unit);

/// A model that is not georeferenced (unit other than "m") has no north.
void draw_scale_and_north(Svg& svg, const MapView& view, const std::string& unit);

/// The ellipse of a standard deviation in plan, drawn `px_per_m` times as large.
void draw_ellipse(Svg& svg, const Eigen::Vector2d& at, const Eigen::Matrix2d& covariance_m2, double px_per_m,
                  std::string_view style);
/// An upright bar with ends, up and down by a standard deviation.
void draw_height_bar(Svg& svg, const Eigen::Vector2d& at, double sigma_m, double px_per_m, std::string_view style);
void draw_triangle(Svg& svg, const Eigen::Vector2d& at, std::string_view style);

}  // namespace collinea
