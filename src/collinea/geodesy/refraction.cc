// SPDX-License-Identifier: Apache-2.0
#include "collinea/geodesy/refraction.h"

#include <cmath>

namespace collinea {
namespace {

// The standard atmosphere (ISO 2533): a temperature that falls by 6.5 K/km from 288.15 K up to 11 km, constant above.
constexpr double kLapse_per_km = 6.5 / 288.15, kPressurePower = 5.2559, kTropopause_km = 11;
constexpr double kRefractivity = 277e-6;   // n - 1 of light in dry air at the sea, 15 degrees
constexpr double kHomogeneous_km = 8.434;  // pressure over density times gravity, at the sea
constexpr double kScaleAbove_km = 6.3416;  // the same at 216.65 K

struct Air {
  double pressure, density;  // of those at the sea
};

Air air_at(double height_km) {
  const double below = std::fmin(height_km, kTropopause_km), relative = 1 - kLapse_per_km * below;
  const double above = std::exp(-(height_km - below) / kScaleAbove_km);
  return {std::pow(relative, kPressurePower) * above, std::pow(relative, kPressurePower - 1) * above};
}

}  // namespace

// Snell's law over thin layers: the direction at a height differs from that at the camera by (n - n_camera) tan; the
// mean of n - 1 over the way is that of the density, whose integral is the difference of pressure.
double refraction_rad(double camera_height_m, double point_height_m) {
  const double camera_km = camera_height_m / 1000, point_km = point_height_m / 1000, way_km = camera_km - point_km;
  if (std::abs(way_km) < 1e-6) return 0;
  const Air camera = air_at(camera_km), point = air_at(point_km);
  const double mean_density = kHomogeneous_km * (point.pressure - camera.pressure) / way_km;
  return kRefractivity * (mean_density - camera.density);
}

}  // namespace collinea
