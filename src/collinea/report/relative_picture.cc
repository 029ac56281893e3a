// SPDX-License-Identifier: Apache-2.0
// The picture of a pair's geometry.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/report/internal/drawing_panel.h"
#include "collinea/report/relative_report.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSize = DrawingPanel::kSize;

// Points of the model in the first camera, in the unit of the base.
std::vector<Vector3d> points_of(const RelativeReport& report) {
  std::vector<Vector3d> out;
  for (const auto& point : report.model.points)
    if (point && point->in_front) out.emplace_back(point->position.x(), -point->position.y(), -point->position.z());
  return out;
}

// Seen along the base: cylinder and plane through the base are a circle and a line there.
DrawingPanel along_base(const RelativeReport& report, const std::vector<Vector3d>& points) {
  const PairShape& shape = *report.shape;
  DrawingPanel panel(0);
  panel.widen({0, 0});
  std::vector<Vector2d> across;
  double far = 0;
  for (const Vector3d& p : points) {
    across.emplace_back(shape.across_in_first.transpose() * p);
    panel.widen(across.back());
    far = std::max(far, across.back().norm());
  }
  const bool draws_circle = shape.cylinder && shape.cylinder->radius < 2 * shape.distance;
  if (draws_circle) {
    const Vector2d centre = shape.cylinder->centre * report.base;
    const Vector2d r = Vector2d::Constant(shape.cylinder->radius * report.base);
    panel.widen(centre - r);
    panel.widen(centre + r);
    panel.circle(centre, shape.cylinder->radius * report.base);
  }
  const double way = shape.base_plane_direction.y() < 0 ? -1 : 1;
  panel.line({0, 0}, way * far * shape.base_plane_direction, "stroke='#383' stroke-dasharray='6 4'");
  for (const Vector2d& p : across) panel.dot(p);
  panel.square({0, 0}, "base");
  panel.words(18, "points seen along the base; nearest critical cylinder, plane through the base");
  if (shape.cylinder)
    panel.words(kSize - 24, fmt::format("cylinder: roughness {:.2g} % of the distance, epsilon {:.2g}",
                                        100 * shape.cylinder->roughness / shape.distance, shape.epsilon));
  panel.words(kSize - 8, fmt::format("plane through the base: roughness {:.2g} % of the distance",
                                     100 * shape.base_plane_roughness / shape.distance));
  return panel;
}

// Seen along the plane that fits best, and across the base: the plane is a line, the base is as long as it can be.
DrawingPanel along_plane(const RelativeReport& report, const std::vector<Vector3d>& points) {
  const PairShape& shape = *report.shape;
  const Vector3d base = base_in_first(report.orientation.second_from_first);
  const Vector3d normal = shape.plane_normal * (shape.plane_normal.dot(shape.plane_middle) < 0 ? -1 : 1);
  Vector3d along = base - normal * normal.dot(base);
  along = along.norm() > 1e-6 ? along.normalized() : normal.unitOrthogonal();
  DrawingPanel panel(kSize);
  panel.widen({0, 0});
  const auto seen = [&](const Vector3d& p) { return Vector2d(along.dot(p), normal.dot(p)); };
  for (const Vector3d& p : points) panel.widen(seen(p));
  panel.widen(seen(base * report.base));
  const Vector2d middle = seen(shape.plane_middle * report.base);
  double least = middle.x(), most = least;
  for (const Vector3d& p : points) {
    least = std::min(least, along.dot(p));
    most = std::max(most, along.dot(p));
  }
  panel.line({least, middle.y()}, {most, middle.y()}, "stroke='#b33' stroke-width='1.5'");
  panel.line({0, 0}, seen(base * report.base), "stroke='#000'");
  for (const Vector3d& p : points) panel.dot(seen(p));
  panel.square({0, 0}, "left");
  panel.square(seen(base * report.base), "right");
  panel.words(18, "points seen along the plane that fits them best");
  panel.words(kSize - 8,
              fmt::format("plane: roughness {:.2g} % of the distance", 100 * shape.plane_roughness / shape.distance));
  return panel;
}

}  // namespace

std::string pair_shape_svg(const RelativeReport& report) {
  std::string body;
  if (report.shape) {
    const std::vector<Vector3d> points = points_of(report);
    body = along_base(report, points).body() + along_plane(report, points).body();
  }
  return drawing_of_panels(2, 1, body);
}

}  // namespace collinea
