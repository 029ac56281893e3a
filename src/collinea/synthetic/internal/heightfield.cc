// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/heightfield.h"

#include <algorithm>
#include <cmath>

#include "collinea/base/result.h"
#include "collinea/synthetic/internal/cell_walk.h"

namespace collinea {

/// The height over one cell: base + a u + b v + c u v with u, v in [0, 1].
struct Heightfield::Patch {
  double base, a, b, c;
};

Heightfield::Heightfield(double west_m, double south_m, double cell_m, int width, int height,
                         std::vector<float> heights_m)
    : west_m_(west_m),
      south_m_(south_m),
      cell_m_(cell_m),
      width_(width),
      height_(height),
      heights_m_(std::move(heights_m)) {
  COLLINEA_CHECK(width >= 2 && height >= 2 && cell_m > 0);
  COLLINEA_CHECK(heights_m_.size() == std::size_t(width) * std::size_t(height));
  const auto [low, high] = std::minmax_element(heights_m_.begin(), heights_m_.end());
  lowest_m_ = *low;
  highest_m_ = *high;
}

Heightfield::Patch Heightfield::patch(int column, int row) const {
  const float* south = heights_m_.data() + std::size_t(row) * std::size_t(width_) + column;
  const float* north = south + width_;
  const double base = south[0], east = south[1], up = north[0], corner = north[1];
  return {base, east - base, up - base, corner - east - up + base};
}

Heightfield::Patch Heightfield::patch_at(double x, double y, double& u, double& v) const {
  u = std::clamp((x - west_m_) / cell_m_, 0.0, double(cells_x()));
  v = std::clamp((y - south_m_) / cell_m_, 0.0, double(cells_y()));
  const int column = std::min(int(u), cells_x() - 1), row = std::min(int(v), cells_y() - 1);
  u -= column;
  v -= row;
  return patch(column, row);
}

double Heightfield::height(double x, double y) const {
  double u, v;
  const Patch p = patch_at(x, y, u, v);
  return p.base + p.a * u + p.b * v + p.c * u * v;
}

Eigen::Vector3d Heightfield::normal(double x, double y) const {
  double u, v;
  const Patch p = patch_at(x, y, u, v);
  return Eigen::Vector3d(-(p.a + p.c * v), -(p.b + p.c * u), cell_m_).normalized();
}

std::optional<double> Heightfield::meet(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double start,
                                        double end) const {
  const double scale = 1 / cell_m_;
  const double x = (origin.x() - west_m_) * scale, y = (origin.y() - south_m_) * scale;
  const double dx = direction.x() * scale, dy = direction.y() * scale, dz = direction.z();
  CellWalk walk(x, y, dx, dy, start, cells_x(), cells_y());
  for (double t = start;;) {
    const double leave = std::min(walk.exit(), end), length = leave - t;
    const Patch p = patch(walk.column(), walk.row());
    // Height of the line above the patch, s after t: f0 + f1 s + f2 s^2.
    const double u = x + t * dx - walk.column(), v = y + t * dy - walk.row();
    const double f0 = origin.z() + t * dz - (p.base + p.a * u + p.b * v + p.c * u * v);
    const double f1 = dz - p.a * dx - p.b * dy - p.c * (u * dy + v * dx);
    const double f2 = -p.c * dx * dy;
    if (f0 <= 0) return t;
    const double at_exit = f0 + length * (f1 + length * f2);
    const double discriminant = f1 * f1 - 4 * f2 * f0;
    const bool dips = f2 > 0 && f1 < 0 && -f1 < 2 * f2 * length && discriminant >= 0;
    if (at_exit <= 0 || dips) return std::min(t + 2 * f0 / (-f1 + std::sqrt(std::max(0.0, discriminant))), leave);
    if (leave >= end || !walk.advance()) return std::nullopt;
    t = leave;
  }
}

double Heightfield::highest(int column, int row, int count) const {
  float top = heights_m_[std::size_t(row) * std::size_t(width_) + std::size_t(column)];
  for (int y = row; y <= std::min(row + count, height_ - 1); ++y)
    for (int x = column; x <= std::min(column + count, width_ - 1); ++x)
      top = std::max(top, heights_m_[std::size_t(y) * std::size_t(width_) + std::size_t(x)]);
  return top;
}

}  // namespace collinea
