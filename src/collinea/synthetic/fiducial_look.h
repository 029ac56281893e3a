// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "collinea/camera/film_calibration.h"

namespace collinea {

/// The brightness, 0 to 1, of a fiducial mark at a position [mm] from it, with its axis along x. Told apart from the
/// drawings by which marks are found, so that an error there shows.
inline double mark_brightness(MarkKind kind, double x, double y, double size, double line) {
  const double r = std::hypot(x, y);
  switch (kind) {
    case MarkKind::kDot:
      return r < size / 2 ? 1 : 0;
    case MarkKind::kRing:
      return r < size / 2 && r > size / 2 - line ? 1 : 0;
    case MarkKind::kCross:
      return (std::abs(x) < line / 2 && std::abs(y) < size / 2) || (std::abs(y) < line / 2 && std::abs(x) < size / 2);
    case MarkKind::kNotch:
      return x > std::abs(y) || x > size / 2 ? 1 : 0;
    case MarkKind::kCorner: {
      const double a = (x + y) * std::numbers::sqrt2 / 2, b = (x - y) * std::numbers::sqrt2 / 2;
      const auto arm = [&](double along, double across) {
        return std::abs(across) < line / 2 && along > -line / 2 && along < size / 2;
      };
      return arm(a, b) || arm(b, a) ? 1 : 0;
    }
  }
  return 0;
}

/// Where the axis of a mark that has one (corner, notch) looks in a scan: to the middle of the film, in eighths of a
/// turn, from the column towards the row.
inline double mark_axis_rad(const CalibratedMark& mark) {
  const bool has_axis = mark.kind == MarkKind::kCorner || mark.kind == MarkKind::kNotch;
  constexpr double kEighth = std::numbers::pi / 4;
  return has_axis ? std::round(std::atan2(mark.film_mm.y(), -mark.film_mm.x()) / kEighth) * kEighth : 0;
}

}  // namespace collinea
