// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace collinea {

/// A point of the left image of an epipolar pair, found in the right one.
struct LevelPoint {
  Eigen::Vector2d left_px;  ///< middle of a pixel
  double disparity_px = 0;  ///< column left less column right
  double row_px = 0;        ///< row right less row left: y-parallax
  double ncc = 0;
  double sigma_px = 0;                ///< of the disparity, by what the grey values left
  Eigen::Vector2d gradient = {0, 0};  ///< of the disparity, along columns and rows
};

}  // namespace collinea
