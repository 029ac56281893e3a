// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/quality/examine.h"

namespace collinea {

/// The standard deviations of AdditionalSet's parameters in an adjustment: pseudo-observations of zero, 0.5 % of the
/// focal length, where `fixed` does not name them ("a3"). Parameters of the model that the set spans by itself are
/// fixed: b1, b2, p1, p2 and with cubic functions k1 (not of kFourier, which is no polynomial). Nothing when `fixed`
/// names one that there is not.
[[nodiscard]] std::optional<CameraSigmas> with_additional(CameraSigmas sigmas, const Camera& camera,
                                                          const std::vector<std::string>& fixed);

/// One additional parameter after the adjustment.
struct AdditionalParameter {
  int param = 0;                      ///< of Camera::params
  double value_px = 0, sigma_px = 0;  ///< times sigma0 when that is estimated
  double chance = 1;                  ///< that a parameter that is zero comes out as large as this (t-test)
  bool significant = false;
  double largest_px = 0;  ///< what it shifts, at most, over the image
  /// With the other free parameters of the camera: the one it is most alike, and how far they all together replace it
  /// (multiple correlation).
  int partner = -1;
  double correlation = 0, multiple_correlation = 0;
  bool keep = false;  ///< by the proposal
};

/// What the adjustment says of the additional parameters of a camera.
struct AdditionalTest {
  CameraId camera;
  std::vector<AdditionalParameter> parameters;  ///< the free ones, ascending
  double f = 0, chance = 1;                     ///< F-test of all of them at once: are they zero?
  /// The proposal: parameters are dropped one by one, the least significant first, each time with the others as they
  /// would be without those before, until all that stay are significant. F-test of the dropped ones together.
  int kept = 0;
  double dropped_f = 0, dropped_chance = 1;
};

/// For every camera with free additional parameters that has a covariance. `level`: chance that a parameter that is
/// zero is called significant.
[[nodiscard]] std::vector<AdditionalTest> test_additional(const Block& block, const Examined& adjusted,
                                                          bool sigma0_known, double level);

}  // namespace collinea
