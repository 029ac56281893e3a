// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/calibration.h"

#include <algorithm>
#include <vector>

namespace collinea {
namespace {

std::optional<std::vector<int>> free_params(const std::string& calibration) {
  using C = Camera;
  if (calibration == "none") return std::vector<int>{};
  if (calibration == "focal") return std::vector<int>{C::kF};
  if (calibration == "focal_radial") return std::vector<int>{C::kF, C::kK1, C::kK2};
  std::vector<int> brown{C::kF, C::kCx, C::kCy, C::kK1, C::kK2, C::kK3, C::kK4, C::kP1, C::kP2};
  if (calibration == "brown") return brown;
  brown.insert(brown.end(), {C::kB1, C::kB2});
  if (calibration == "brown_affinity") return brown;
  return std::nullopt;
}

// Standard deviations of the weak observations of calibration.
double weak_sigma(const Camera& camera, int param) {
  switch (param) {
    case Camera::kF:
      return camera.prior.sigma_f_px;
    case Camera::kCx:
    case Camera::kCy:
      return 0.03 * camera.width_px;
    case Camera::kK1:
      return 0.2;
    case Camera::kK2:
    case Camera::kK3:
    case Camera::kK4:
      return 0.5;
    case Camera::kP1:
    case Camera::kP2:
      return 0.01;
    default:
      return 0.005 * camera.focal_px();
  }
}

}  // namespace

bool is_calibration(const std::string& name) { return free_params(name).has_value(); }

std::optional<CameraSigmas> calibration_named(const std::string& name, const Camera& first) {
  const auto free = free_params(name);
  if (!free) return std::nullopt;
  CameraSigmas sigmas{};
  const std::vector<int> has = params_of(first);
  for (const int param : *free)
    if (std::ranges::find(has, param) != has.end()) sigmas[static_cast<std::size_t>(param)] = weak_sigma(first, param);
  return sigmas;
}

}  // namespace collinea
