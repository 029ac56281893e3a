// SPDX-License-Identifier: Apache-2.0
// The picture of a pair's geometry.
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "collinea/report/relative_report.h"

namespace collinea {

std::string pair_shape_svg(const RelativeReport& report) {
  constexpr double kSize = 480, kMargin = 40;
  std::string body;
  if (report.shape) {
    const PairShape& shape = *report.shape;
    std::vector<Eigen::Vector2d> across;
    Eigen::Vector2d low(0, 0), high(0, 0);
    const auto widen = [&](const Eigen::Vector2d& p) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    };
    for (const auto& point : report.model.points) {
      if (!point || !point->in_front) continue;
      const Eigen::Vector3d in_camera =
          Eigen::Vector3d(point->position.x(), -point->position.y(), -point->position.z());
      across.emplace_back(shape.across_in_first.transpose() * in_camera);
      widen(across.back());
    }
    const bool draws_circle = shape.cylinder && shape.cylinder->radius < 2 * shape.distance;
    if (draws_circle) {
      const Eigen::Vector2d r = Eigen::Vector2d::Constant(shape.cylinder->radius * report.base);
      widen(shape.cylinder->centre * report.base - r);
      widen(shape.cylinder->centre * report.base + r);
    }
    const double scale = (kSize - 2 * kMargin) / std::max({high.x() - low.x(), high.y() - low.y(), 1e-9});
    const auto at = [&](const Eigen::Vector2d& p) {
      return Eigen::Vector2d(kMargin + (p.x() - low.x()) * scale, kMargin + (p.y() - low.y()) * scale);
    };
    if (draws_circle) {
      const Eigen::Vector2d c = at(shape.cylinder->centre * report.base);
      body += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='{:.1f}' fill='none' stroke='#b33' stroke-width='1.5'/>\n",
                          c.x(), c.y(), shape.cylinder->radius * report.base * scale);
    }
    for (const Eigen::Vector2d& p : across)
      body += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.5' fill='#246'/>\n", at(p).x(), at(p).y());
    const Eigen::Vector2d base = at({0, 0});
    body += fmt::format(
        "<rect x='{:.1f}' y='{:.1f}' width='8' height='8' fill='#000'/>\n<text x='{:.1f}' y='{:.1f}'>base</text>\n",
        base.x() - 4, base.y() - 4, base.x() + 8, base.y() - 6);
    if (shape.cylinder)
      body += fmt::format("<text x='10' y='{:.0f}'>roughness {:.1f} % of the distance, epsilon {:.2g}</text>\n",
                          kSize - 10, 100 * shape.cylinder->roughness / shape.distance, shape.epsilon);
  }
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {0:.0f}' width='{0:.0f}' height='{0:.0f}' "
      "font-family='sans-serif' font-size='13'>\n<rect width='100%' height='100%' fill='#fff'/>\n<text x='10' y='18'>"
      "points seen along the base, and the nearest critical cylinder</text>\n{1}</svg>\n",
      kSize, body);
}

}  // namespace collinea
