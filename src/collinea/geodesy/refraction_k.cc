// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/refraction_k.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

ImageRefraction refraction_in_image(const Eigen::Vector2d& xy, double principal_distance, const CardanAngles& angles,
                                    const RefractionHeights& heights, const RefractionModel& model,
                                    double sigma_coordinate) {
  const double c = principal_distance, steepest = std::cos(89 * std::numbers::pi / 180);
  const Eigen::Matrix3d image_from_object = rotation_matrix(angles);
  const Eigen::Vector3d ray = image_from_object.transpose() * Eigen::Vector3d(xy.x(), xy.y(), -c);
  ImageRefraction out;
  out.angle_rad = std::acos(std::clamp(-ray.z() / ray.norm(), -1.0, 1.0));
  if (!(-ray.z() > steepest * ray.norm())) return out;
  const Eigen::Vector2d level = -c * ray.head<2>() / ray.z();
  const double radial = level.norm();
  if (!(radial > 0)) return out;
  const RadialRefraction at =
      model.by_atmosphere ? refraction_by_atmosphere(radial, c, heights.camera_m, heights.ground_m, sigma_coordinate,
                                                     heights.sigma_difference_m)
                          : refraction_by_coefficient(radial, c, heights.camera_m - heights.ground_m, sigma_coordinate,
                                                      heights.sigma_difference_m, model.coefficient);
  // From the level image back to the tilted one, and the derivative along the shift.
  const auto in_image = [&](double by) -> Eigen::Vector2d {
    const Eigen::Vector2d shifted = level * (1 + by / radial);
    const Eigen::Vector3d back = image_from_object * Eigen::Vector3d(shifted.x(), shifted.y(), -c);
    return -c * back.head<2>() / back.z();
  };
  const double step = 1e-4 * c;
  out.shift = in_image(at.shift) - xy;
  out.sigma = at.sigma * ((in_image(at.shift + step) - in_image(at.shift - step)) / (2 * step)).cwiseAbs();
  return out;
}

}  // namespace collinea
