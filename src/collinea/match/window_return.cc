// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/window_return.h"

#include <Eigen/Dense>
#include <cmath>

namespace collinea {

using Eigen::Vector2d;

std::optional<ImageLine2> epipolar_line(const Eigen::Matrix3d& fundamental, const Vector2d& px) {
  const Eigen::Vector3d line = fundamental * px.homogeneous();
  const double norm = line.head<2>().norm();
  // The terms of which the line is the sum: what is left of them near the epipole is rounding.
  const double size = (fundamental.topRows<2>().cwiseAbs() * px.homogeneous().cwiseAbs()).norm();
  if (!std::isfinite(norm) || !(norm > 1e-12 * size)) return std::nullopt;
  return ImageLine2{line[0] / norm, line[1] / norm, line[2] / norm};
}

ReturnedWindow match_window_and_back(const GreyImage& left, const Vector2d& left_px, const GreyImage& right,
                                     const WindowStart& start, const WindowOptions& options, const Vector2d& left_line,
                                     double return_px) {
  ReturnedWindow out{match_window(left, left_px, right, start, options)};
  if (out.match.outcome != WindowOutcome::kFound) return out;
  const WindowMatch back =
      match_window(right, out.match.position_px, left, {left_px, out.match.map.inverse(), left_line}, options);
  if (back.outcome == WindowOutcome::kFound) out.returned_px = (back.position_px - left_px).norm();
  if (!out.returned_px || *out.returned_px > return_px) out.match.outcome = WindowOutcome::kNotReturned;
  return out;
}

}  // namespace collinea
