// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/calibration.h"

#include <algorithm>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {
namespace {

std::vector<int> free_params(Calibration calibration) {
  using C = Camera;
  switch (calibration) {
    case Calibration::kNone:
      return {};
    case Calibration::kFocal:
      return {C::kF};
    case Calibration::kFocalRadial:
      return {C::kF, C::kK1, C::kK2};
    case Calibration::kBrown:
      return {C::kF, C::kCx, C::kCy, C::kK1, C::kK2, C::kK3, C::kK4, C::kP1, C::kP2};
    case Calibration::kBrownAffinity:
      return {C::kF, C::kCx, C::kCy, C::kK1, C::kK2, C::kK3, C::kK4, C::kP1, C::kP2, C::kB1, C::kB2};
  }
  bug("a calibration without parameters");
}

// Standard deviations of the pseudo-observations of calibration.
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

CameraSigmas calibration_sigmas(Calibration calibration, const Camera& first) {
  CameraSigmas sigmas{};
  const std::vector<int> has = params_of(first);
  for (const int param : free_params(calibration))
    if (std::ranges::find(has, param) != has.end()) sigmas[static_cast<std::size_t>(param)] = weak_sigma(first, param);
  return sigmas;
}

}  // namespace collinea
