// SPDX-License-Identifier: Apache-2.0
// The picture of a pair's geometry.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/report/relative_report.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kSize = 480, kMargin = 40;

// Points of the model in the first camera, in the unit of the base.
std::vector<Vector3d> points_of(const RelativeReport& report) {
  std::vector<Vector3d> out;
  for (const auto& point : report.model.points)
    if (point && point->in_front) out.emplace_back(point->position.x(), -point->position.y(), -point->position.z());
  return out;
}

// One drawing of the two, side by side: what is to be seen in it, and how it is scaled.
class Panel {
 public:
  explicit Panel(double left) : left_(left) {}

  void widen(const Vector2d& p) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
  }
  [[nodiscard]] double scale() const { return (kSize - 2 * kMargin) / std::max((high_ - low_).maxCoeff(), 1e-9); }
  [[nodiscard]] Vector2d at(const Vector2d& p) const {
    return Vector2d(left_ + kMargin, kMargin) + (p - low_) * scale();
  }
  void dot(const Vector2d& p) {
    body_ += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='2.5' fill='#246'/>\n", at(p).x(), at(p).y());
  }
  void circle(const Vector2d& centre, double radius) {
    const Vector2d c = at(centre);
    body_ += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='{:.1f}' fill='none' stroke='#b33' stroke-width='1.5'/>\n",
                         c.x(), c.y(), radius * scale());
  }
  void line(const Vector2d& from, const Vector2d& to, const char* look) {
    const Vector2d a = at(from), b = at(to);
    body_ +=
        fmt::format("<line x1='{:.1f}' y1='{:.1f}' x2='{:.1f}' y2='{:.1f}' {}/>\n", a.x(), a.y(), b.x(), b.y(), look);
  }
  void square(const Vector2d& p, const char* name) {
    const Vector2d a = at(p);
    body_ += fmt::format(
        "<rect x='{:.1f}' y='{:.1f}' width='8' height='8' fill='#000'/>\n<text x='{:.1f}' y='{:.1f}'>{}</text>\n",
        a.x() - 4, a.y() - 4, a.x() + 8, a.y() - 6, name);
  }
  void words(double y, const std::string& text) {
    body_ += fmt::format("<text x='{:.0f}' y='{:.0f}'>{}</text>\n", left_ + 10, y, text);
  }
  [[nodiscard]] const std::string& body() const { return body_; }

 private:
  double left_;
  Vector2d low_ = {0, 0}, high_ = {0, 0};
  std::string body_;
};

// Seen along the base: cylinder and plane through the base are a circle and a line there.
Panel along_base(const RelativeReport& report, const std::vector<Vector3d>& points) {
  const PairShape& shape = *report.shape;
  Panel panel(0);
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
Panel along_plane(const RelativeReport& report, const std::vector<Vector3d>& points) {
  const PairShape& shape = *report.shape;
  const Vector3d base = base_in_first(report.orientation.second_from_first);
  const Vector3d normal = shape.plane_normal * (shape.plane_normal.dot(shape.plane_middle) < 0 ? -1 : 1);
  Vector3d along = base - normal * normal.dot(base);
  along = along.norm() > 1e-6 ? along.normalized() : normal.unitOrthogonal();
  Panel panel(kSize);
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
  return fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0:.0f} {1:.0f}' width='{0:.0f}' height='{1:.0f}' "
      "font-family='sans-serif' font-size='12'>\n<rect width='100%' height='100%' fill='#fff'/>\n{2}</svg>\n",
      2 * kSize, kSize, body);
}

}  // namespace collinea
