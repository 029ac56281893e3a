// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>

#include "collinea/camera/additional.h"

namespace collinea {

/// The parameters that cameras have, by name: those of the models, of which each has some, and behind them those of the
/// additional set. A parameter means the same in every model that has it. They share one array, so that the adjustment
/// numbers them once for all models.
struct CameraParameters {
  enum Param : int { kF, kCx, kCy, kK1, kK2, kK3, kP1, kP2, kB1, kB2, kK4, kParams };
  static constexpr int kAllParams = kParams + static_cast<int>(kMostAdditional);
  static constexpr std::array<std::string_view, kParams> kParamNames = {"f",  "cx", "cy", "k1", "k2", "k3",
                                                                        "p1", "p2", "b1", "b2", "k4"};
  static constexpr std::array<std::string_view, kParams> kParamUnits = {"px", "px", "px", "1",  "1", "1",
                                                                        "1",  "1",  "px", "px", "1"};
};

using Matrix23 = Eigen::Matrix<double, 2, 3>;
using Matrix2P = Eigen::Matrix<double, 2, CameraParameters::kAllParams>;

}  // namespace collinea
