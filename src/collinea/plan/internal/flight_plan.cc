// SPDX-License-Identifier: Apache-2.0
#include "collinea/plan/internal/flight_plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kRadians = std::numbers::pi / 180;
constexpr std::size_t kMostImages = 20'000;
constexpr double kSteepest_rad = 75 * kRadians;  // beyond it images show the horizon

struct Range {
  double low = 1e300, high = -1e300;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double size() const { return high - low; }
  [[nodiscard]] double middle() const { return (low + high) / 2; }
};

Range extent(const MapArea& area, const Vector2d& direction) {
  Range range;
  for (const Vector2d& corner : area) range.add(direction.dot(corner));
  return range;
}

// The part of the area between two lines along the strips, as a range along them.
Range extent_between(const MapArea& area, const StripAxes& axes, double low, double high) {
  Range range;
  for (std::size_t i = 0; i < area.size(); ++i) {
    const Vector2d a = axes.uv(area[i]), b = axes.uv(area[(i + 1) % area.size()]);
    if (a.y() >= low && a.y() <= high) range.add(a.x());
    for (const double level : {low, high})
      if ((a.y() - level) * (b.y() - level) < 0) range.add(a.x() + (level - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
  }
  return range;
}

// The direction in which the area is narrowest: one of its edges.
double narrowest_heading(const MapArea& area) {
  double best = 0, narrowest = 1e300;
  for (std::size_t i = 0; i < area.size(); ++i) {
    const Vector2d edge = area[(i + 1) % area.size()] - area[i];
    if (!(edge.norm() > 0)) continue;
    const double heading = std::atan2(edge.x(), edge.y()), width = extent(area, StripAxes(heading).across).size();
    if (width >= narrowest * (1 - 1e-9)) continue;
    narrowest = width;
    best = heading;
  }
  return best;
}

// As few steps as reach from end to end.
int steps_over(double length_m, double step_m) { return int(std::ceil(length_m / step_m - 1e-6)); }

void add_strip(FlightPlan& plan, const StripAxes& axes, double v, const Range& range, double base_m, double height_m,
               bool cross) {
  const int steps = steps_over(range.size(), base_m), strip = plan.strips + plan.cross_strips;
  const double heading = std::atan2(axes.along.x(), axes.along.y());
  const double sign = strip % 2 ? -1 : 1;
  for (int i = 0; i <= steps; ++i) {
    const Vector2d position = axes.position(range.middle() + sign * (i - 0.5 * steps) * base_m, v);
    plan.images.push_back(
        {strip, cross, {position.x(), position.y(), height_m}, sign > 0 ? heading : heading + std::numbers::pi});
  }
  ++(cross ? plan.cross_strips : plan.strips);
}

Result<> check_count(double count) {
  if (count <= double(kMostImages)) return {};
  return fail(Errc::kBadInput,
              "the flight would take more than 20000 images: a larger GSD, less overlap or a part of "
              "the site is needed");
}

Result<> add_strips(FlightPlan& plan) {
  const StripAxes axes(plan.heading_rad);
  const Range across = extent(plan.area, axes.across), along = extent(plan.area, axes.along);
  const int steps = steps_over(across.size(), plan.spacing_m);
  COLLINEA_TRY(check_count((steps + 1.0) * (along.size() / plan.base_m + 1)));
  for (int i = 0; i <= steps; ++i) {
    const double v = across.middle() + (i - 0.5 * steps) * plan.spacing_m;
    add_strip(plan, axes, v, extent_between(plan.area, axes, v - plan.spacing_m, v + plan.spacing_m), plan.base_m,
              plan.height_m, false);
  }
  return {};
}

Result<> add_cross_strips(FlightPlan& plan, const FlightOptions& options) {
  const StripAxes axes(plan.heading_rad + std::numbers::pi / 2);
  const Range across = extent(plan.area, axes.across), along = extent(plan.area, axes.along);
  const double factor = options.cross_height, spacing_m = factor * plan.spacing_m;
  COLLINEA_TRY(check_count(options.cross_strips * (along.size() / (factor * plan.base_m) + 1)));
  for (int i = 0; i < options.cross_strips; ++i) {
    const double share = options.cross_strips == 1 ? 0.5 : double(i) / (options.cross_strips - 1);
    const double v = across.low + share * across.size();
    add_strip(plan, axes, v, extent_between(plan.area, axes, v - spacing_m, v + spacing_m), factor * plan.base_m,
              factor * plan.height_m, true);
  }
  return {};
}

// That given, or the rectangle of the options.
Result<MapArea> site_of(const FlightOptions& o, const MapArea& area) {
  if (area.empty()) {
    if (!o.east_m || !o.north_m)
      return fail(Errc::kBadInput, "plan which site? Give its extent to the east and north, or a file with its corners",
                  {"east_m"_option, "north_m"_option, "area"_option});
    const double east = o.west_m + *o.east_m, north = o.south_m + *o.north_m;
    return MapArea{{o.west_m, o.south_m}, {east, o.south_m}, {east, north}, {o.west_m, north}};
  }
  if (o.east_m || o.north_m || o.west_m != 0 || o.south_m != 0)
    return fail(Errc::kBadInput, "give an area or the extent of a rectangle, not both",
                {"area"_option, "east_m"_option, "north_m"_option});
  const double extent_m = std::max(extent(area, Vector2d::UnitX()).size(), extent(area, Vector2d::UnitY()).size());
  if (area.size() < 3 || !(size_m2(area) > 1e-6 * extent_m * extent_m))
    return fail(Errc::kBadInput, "the corners of the area enclose nothing");
  return area;
}

}  // namespace

StripAxes::StripAxes(double heading_rad)
    : along(std::sin(heading_rad), std::cos(heading_rad)), across(along.y(), -along.x()) {}

Result<FlightPlan> plan_flight(const FlightOptions& o, const MapArea& area) {
  COLLINEA_TRY(validate(o));
  FlightPlan plan;
  COLLINEA_TRY(plan.area, site_of(o, area));
  const double focal_px = o.focal_mm / o.sensor_width_mm * o.width_px;
  plan.camera = ideal_camera(focal_px, o.width_px, o.height_px);
  plan.camera.name = "planned camera";
  plan.camera.prior.source = Provenance::kGiven;
  if (o.tilt_deg * kRadians + std::atan(o.height_px / (2 * focal_px)) > kSteepest_rad)
    return fail(Errc::kBadInput,
                "the upper edge of the images would look higher than 75 degrees from straight down: "
                "less tilt_deg or a longer focal length is needed");
  plan.height_m = o.height_m.value_or(o.gsd_m * focal_px);
  if (o.relief_m > 0.8 * plan.height_m)
    return fail(Errc::kBadInput, "relief_m is more than four fifths of the flying height");
  plan.gsd_m = plan.height_m / focal_px;
  plan.tilt_rad = o.tilt_deg * kRadians;
  plan.relief_m = o.relief_m;
  plan.across_m = o.width_px * plan.gsd_m;
  plan.along_m = o.height_px * plan.gsd_m;
  plan.base_m = (1 - o.forward_overlap) * plan.along_m;
  plan.spacing_m = (1 - o.side_overlap) * plan.across_m;
  plan.heading_rad = o.heading_deg ? *o.heading_deg * kRadians : narrowest_heading(plan.area);
  COLLINEA_TRY(add_strips(plan));
  COLLINEA_TRY(add_cross_strips(plan, o));
  COLLINEA_TRY(check_count(double(plan.images.size())));
  for (std::size_t i = 1; i < plan.images.size(); ++i)
    plan.path_m += (plan.images[i].centre - plan.images[i - 1].centre).norm();
  return plan;
}

}  // namespace collinea
