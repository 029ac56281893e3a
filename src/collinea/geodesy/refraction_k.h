// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/geometry/rotation_angles.h"

namespace collinea {

/// The refraction coefficient of temperate latitudes is 0.13 to 0.15 (Mussio 2.5.1).
inline constexpr double kUsualRefractionCoefficient = 0.13;

/// How much farther from the principal point of a vertical photograph a point is seen, by a ray that is bent to an arc
/// of radius R / K (Mussio 2.5.1, erratum E24):  ds = K / (2 R) h s (1 + s^2 / c^2). Corrected: s - ds.
struct RadialRefraction {
  double shift = 0;  ///< in the unit of the radial distance
  double sigma = 0;  ///< of the shift, by those of height and radial distance (2.5.2, erratum E25)
};
/// Radial distance s and principal distance c in one unit, the height h of the camera over the ground in metres. K
/// constant is sensible up to some kilometres of height alone: refraction_rad() has an atmosphere that thins out.
[[nodiscard]] RadialRefraction refraction_by_coefficient(double radial_distance, double principal_distance,
                                                         double height_m, double sigma_radial = 0,
                                                         double sigma_height_m = 0,
                                                         double coefficient = kUsualRefractionCoefficient);

/// The same shift for the standard atmosphere, ds = c (1 + s^2 / c^2) tan(alpha) times refraction_rad(), and its
/// standard deviation by the same two sigmas (differences of height of 1 m).
[[nodiscard]] RadialRefraction refraction_by_atmosphere(double radial_distance, double principal_distance,
                                                        double camera_height_m, double ground_height_m,
                                                        double sigma_radial = 0, double sigma_height_m = 0);

/// By which air refraction is computed.
struct RefractionModel {
  bool by_atmosphere = true;  ///< refraction_by_atmosphere(); otherwise refraction_by_coefficient()
  double coefficient = kUsualRefractionCoefficient;
};
/// Camera and ground, heights above the sea, and what is known of them.
struct RefractionHeights {
  double camera_m = 0, ground_m = 0;
  double sigma_difference_m = 0;  ///< of the height of the camera over the ground
};
/// The shift by refraction in an image of any attitude.
struct ImageRefraction {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  ///< seen less straight, in the unit of the coordinates
  Eigen::Vector2d sigma = Eigen::Vector2d::Zero();  ///< along it
  double angle_rad = 0;                             ///< of the ray from the nadir
};
/// Coordinates (x right, y up, about the principal point) are brought to the level image at the same centre, shifted
/// there radially from the nadir and brought back (Mussio 2.5.2: strongly tilted images are computed on an ideally
/// horizontal one). The angles are against east, north and up. Zero for a ray at or above the horizon (89 degrees from
/// the nadir and more).
[[nodiscard]] ImageRefraction refraction_in_image(const Eigen::Vector2d& xy, double principal_distance,
                                                  const CardanAngles& angles, const RefractionHeights& heights,
                                                  const RefractionModel& model, double sigma_coordinate = 0);

}  // namespace collinea
