// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/refraction_k.h"

#include <cmath>

#include "collinea/geodesy/refraction.h"

namespace collinea {
namespace {

constexpr double kEarthRadius_m = 6378e3;

}  // namespace

RadialRefraction refraction_by_coefficient(double radial_distance, double principal_distance, double height_m,
                                           double sigma_radial, double sigma_height_m, double coefficient) {
  const double s = radial_distance, slope2 = s * s / (principal_distance * principal_distance);
  const double factor = coefficient / (2 * kEarthRadius_m);
  const double by_height = factor * s * (1 + slope2), by_radial = factor * height_m * (1 + 3 * slope2);
  return {by_height * height_m, std::hypot(by_height * sigma_height_m, by_radial * sigma_radial)};
}

RadialRefraction refraction_by_atmosphere(double radial_distance, double principal_distance, double camera_height_m,
                                          double ground_height_m, double sigma_radial, double sigma_height_m) {
  const double s = radial_distance, slope2 = s * s / (principal_distance * principal_distance);
  const double coefficient = refraction_rad(camera_height_m, ground_height_m);
  const double change =
      (refraction_rad(camera_height_m + 1, ground_height_m) - refraction_rad(camera_height_m - 1, ground_height_m)) / 2;
  return {coefficient * s * (1 + slope2),
          std::hypot(change * s * (1 + slope2) * sigma_height_m, coefficient * (1 + 3 * slope2) * sigma_radial)};
}

}  // namespace collinea
