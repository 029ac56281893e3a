// SPDX-License-Identifier: Apache-2.0
// The danger circle of a station, or the danger cylinder of a projection centre, with what lies on it.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/io/text.h"
#include "collinea/report/internal/drawing_panel.h"
#include "collinea/report/resection_report.h"

namespace collinea {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Image = ResectionReport::Image;

constexpr double kRoundest = 20;  // a circle of a larger radius, in extents of the points, is drawn as none
constexpr const char* kCylinderLook = "stroke='#b33' stroke-width='1.5'";
constexpr const char* kOpenLook = "stroke='#e80' stroke-width='4' stroke-linecap='round'";

// Axes along which the cylinder is seen: the second one is up in the drawing.
struct View {
  Vector3d middle, right, up;

  [[nodiscard]] Vector2d operator()(const Vector3d& p) const { return {right.dot(p - middle), -up.dot(p - middle)}; }
};

double extent_of(const Image& image) {
  double extent = 0;
  for (const auto& one : image.control)
    for (const auto& other : image.control) extent = std::max(extent, (one.position - other.position).norm());
  return extent;
}

// Seen along the axis: map axes as far as the axis leaves them.
View along_axis(const DangerCylinder& danger) {
  const Vector3d axis = danger.axis_in_world;
  const Vector3d to = std::abs(axis.z()) > 0.5 ? Vector3d::UnitY() : Vector3d::UnitZ();
  const Vector3d up = (to - axis * axis.dot(to)).normalized();
  return {danger.middle_in_world, up.cross(axis.z() < 0 ? Vector3d(-axis) : axis), up};
}

// Seen across the axis, with the station to the right of it.
View across_axis(const Image& image) {
  const DangerCylinder& danger = *image.danger;
  const Vector3d to = image.station - danger.middle_in_world;
  Vector3d axis = danger.axis_in_world;
  if (axis.dot(to) < 0) axis = -axis;
  const Vector3d right = to - axis * axis.dot(to);
  return {danger.middle_in_world, right.norm() > 1e-9 * to.norm() ? right.normalized() : axis.unitOrthogonal(), axis};
}

void draw_points(DrawingPanel& panel, const Image& image, const View& seen, bool is_station) {
  for (std::size_t i = 1; i < image.open_stations.size(); ++i)
    panel.line(seen(image.open_stations[i - 1]), seen(image.open_stations[i]), kOpenLook);
  for (const auto& one : image.control) panel.dot(seen(one.position), one.name);
  if (image.open_stations.empty()) panel.square(seen(image.station), is_station ? "station" : "projection centre");
}

DrawingPanel seen_along(const Image& image, bool is_station, double top) {
  const DangerCylinder& danger = *image.danger;
  const View seen = along_axis(danger);
  DrawingPanel panel(0, top);
  for (const auto& one : image.control) panel.widen(seen(one.position));
  if (image.open_stations.empty()) panel.widen(seen(image.station));
  const bool draws_circle = danger.radius_m < kRoundest * extent_of(image);
  if (draws_circle) {
    panel.widen(Vector2d::Constant(-danger.radius_m));
    panel.widen(Vector2d::Constant(danger.radius_m));
    panel.circle({0, 0}, danger.radius_m);
  }
  draw_points(panel, image, seen, is_station);
  panel.words(18, image.name + (is_station ? ": danger circle" : ": danger cylinder, seen along its axis"));
  constexpr double kRounding = 1e-9;  // of the radius
  const double points_off = danger.points_off_m > kRounding * danger.radius_m ? danger.points_off_m : 0;
  panel.words(DrawingPanel::kSize - 24, fmt::format("radius {}, points off the circle {} (RMS)",
                                                    metres_text(danger.radius_m), metres_text(points_off)));
  panel.words(DrawingPanel::kSize - 8,
              image.open_stations.empty()
                  ? fmt::format("{} {} {} the {}", is_station ? "station" : "projection centre",
                                metres_text(std::abs(danger.centre_off_m)),
                                danger.centre_off_m < 0 ? "inside" : "outside", is_station ? "circle" : "cylinder")
                  : std::string("the station is open: anywhere on the thick arc the directions are as measured"));
  return panel;
}

DrawingPanel seen_across(const Image& image, double top) {
  const DangerCylinder& danger = *image.danger;
  const View seen = across_axis(image);
  DrawingPanel panel(DrawingPanel::kSize, top);
  double low = 0, high = 0;
  const auto widen = [&](const Vector3d& p) {
    panel.widen(seen(p));
    low = std::min(low, seen(p).y());
    high = std::max(high, seen(p).y());
  };
  for (const auto& one : image.control) widen(one.position);
  widen(image.station);
  if (danger.radius_m < kRoundest * extent_of(image)) {
    for (const double side : {-danger.radius_m, danger.radius_m}) panel.widen({side, 0});
    for (const double side : {-danger.radius_m, danger.radius_m}) panel.line({side, low}, {side, high}, kCylinderLook);
    panel.line({-danger.radius_m, 0}, {danger.radius_m, 0}, "stroke='#b33' stroke-dasharray='6 4'");
  }
  draw_points(panel, image, seen, false);
  panel.words(18, "seen across its axis, the projection centre to the right");
  return panel;
}

}  // namespace

std::string danger_svg(const ResectionReport& report) {
  std::string body;
  int rows = 0;
  for (const Image& image : report.images) {
    if (!image.danger || image.control.empty()) continue;
    const double top = DrawingPanel::kSize * rows++;
    body += seen_along(image, report.is_station(), top).body();
    if (!report.is_station()) body += seen_across(image, top).body();
  }
  return rows == 0 ? "" : drawing_of_panels(report.is_station() ? 1 : 2, rows, body);
}

}  // namespace collinea
