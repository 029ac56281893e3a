// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>

#include "collinea/base/id.h"

namespace collinea {

// Differences between an adjusted block and what was given: adjusted minus given, in the world frame (east, north, up).
// One form for all: the adjustment makes them, the project keeps them, reports show them. NaN: not known. `fields`
// tells the members in their order, with their names, to whatever writes or reads them.

/// A control or check point after the adjustment.
struct ControlDifference {
  ControlId point;
  bool used = false;  ///< it took part; false: check point, intersected from the images that took part or were fixed
  bool excluded = false;  ///< found wrong, it or its image measurements, and left out; then not used
  int rays = 0;           ///< images that took part or were fixed and in which it was measured
  std::optional<Eigen::Vector3d> position_in_world;  ///< nothing when the rays do not intersect
  Eigen::Vector3d difference_m = Eigen::Vector3d::Constant(
      std::numeric_limits<double>::quiet_NaN());  ///< estimated minus given, in the world frame; NaN: not surveyed
  /// With covariances: of position_in_world [m^2], by the given sigmas (of a check point without its survey) ...
  std::optional<Eigen::Matrix3d> covariance_m2;
  /// ... and what difference_m is expected to be, by the block's covariance times sigma0^2 and the survey as given.
  /// NaN: not known.
  Eigen::Vector3d difference_sigma_m = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

  template <class Visit>
  static void fields(Visit&& visit) {
    using D = ControlDifference;
    visit("point", &D::point);
    visit("used", &D::used);
    visit("excluded", &D::excluded);
    visit("rays", &D::rays);
    visit("position_in_world", &D::position_in_world);
    visit("difference_m", &D::difference_m);
    visit("covariance_m2", &D::covariance_m2);
    visit("difference_sigma_m", &D::difference_sigma_m);
  }
};

/// The position of an image against what its receiver measured.
struct PositionDifference {
  ImageId image;
  Eigen::Vector3d difference_m;  ///< adjusted minus given; NaN on axes that were not given
  double weight = 1;             ///< by the robust loss; below 1: partly disbelieved

  template <class Visit>
  static void fields(Visit&& visit) {
    using D = PositionDifference;
    visit("image", &D::image);
    visit("difference_m", &D::difference_m);
    visit("weight", &D::weight);
  }
};

/// A measurement on the ground after the adjustment.
struct GeodeticDifference {
  std::uint32_t observation = 0;  ///< index in Block::geodetic
  bool used = false;              ///< it took part; false: only compared
  bool excluded = false;          ///< it contradicts the others and was left out; then not used
  double adjusted = 0;            ///< [m] or [rad]
  double difference = 0;          ///< adjusted minus given
  /// With covariances: of `adjusted`, by the given sigmas, and what `difference` is expected to be. NaN: not known.
  double sigma = std::numeric_limits<double>::quiet_NaN();
  double difference_sigma = std::numeric_limits<double>::quiet_NaN();

  template <class Visit>
  static void fields(Visit&& visit) {
    using D = GeodeticDifference;
    visit("observation", &D::observation);
    visit("used", &D::used);
    visit("excluded", &D::excluded);
    visit("adjusted", &D::adjusted);
    visit("difference", &D::difference);
    visit("sigma", &D::sigma);
    visit("difference_sigma", &D::difference_sigma);
  }
};

}  // namespace collinea
