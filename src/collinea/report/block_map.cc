// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/report/internal/figures.h"
#include "collinea/report/internal/map_view.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

void draw_symbol(Svg& svg, const Vector2d& at, const ControlDifference* control, const ControlPoint& point) {
  const bool unused = !control || control->excluded;
  const bool check = unused ? point.role == ControlRole::kCheck : !control->used;
  if (check) {
    svg.circle(at, 6, unused ? "check unused" : "check", point.name);
  } else {
    draw_triangle(svg, at, unused ? "control unused" : "control");
  }
  svg.circle(at, 1, "dot");
  svg.text(at + Vector2d(9, 14), point.name, "start", "label halo");
}

double longest_difference(const ReportInput& input) {
  double longest = 0;
  for (const ControlDifference& control : input.control) {
    if (control.excluded) continue;
    const auto& d = control.difference_m;
    if (std::isfinite(d.x()) && std::isfinite(d.y())) longest = std::max(longest, d.head<2>().norm());
    if (std::isfinite(d.z())) longest = std::max(longest, std::abs(d.z()));
  }
  return longest;
}

// Differences in plan and, beside them, in height, at one exaggeration.
void draw_control(Svg& svg, const MapView& view, const ReportInput& input, const std::string& unit) {
  constexpr double kLongest_px = 48;
  const double longest = longest_difference(input), px_per_unit = longest > 0 ? kLongest_px / longest : 0;
  std::map<ControlId, const ControlDifference*> results;
  for (const ControlDifference& control : input.control) results[control.point] = &control;
  for (const auto& [id, point] : input.block.control) {
    const auto found = results.find(id);
    const ControlDifference* control = found == results.end() ? nullptr : found->second;
    const Vector2d at = view(point.position_in_world);
    draw_symbol(svg, at, control, point);
    if (!control || control->excluded || px_per_unit == 0) continue;
    const auto& d = control->difference_m;
    if (std::isfinite(d.x()) && std::isfinite(d.y()))
      svg.arrow(at, at + px_per_unit * Vector2d(d.x(), -d.y()), "plan_arrow");
    if (std::isfinite(d.z()))
      svg.arrow(at + Vector2d(-11, 0), at + Vector2d(-11, -px_per_unit * d.z()), "height_arrow");
  }
  if (px_per_unit == 0) return;
  const double length = round_below(longest), px = length * px_per_unit;
  const Vector2d corner(view.width - 216, view.height - 44);
  svg.rectangle(corner.x() - 8, corner.y() - 14, 216, 54, "paper");
  svg.arrow(corner, corner + Vector2d(px, 0), "plan_arrow");
  svg.text(corner + Vector2d(60, 4), "in plan, " + scale_text(length, unit));
  svg.arrow(corner + Vector2d(px / 2, 33), corner + Vector2d(px / 2, 11), "height_arrow");
  svg.text(corner + Vector2d(60, 24), "in height (up: too high)");
}

void draw_images(Svg& svg, const MapView& view, const ReportInput& input, const Coverage& coverage) {
  const std::size_t count = coverage.footprints.size();
  const std::string style = count <= 60 ? "footprint" : count <= 600 ? "footprint many" : "footprint crowd";
  if (count <= 3000)
    for (const auto& [id, polygon] : coverage.footprints) {
      Polygon drawn;
      for (const auto& p : polygon) drawn.push_back(view(p));
      svg.polygon(drawn, style);
    }
  for (const auto& [id, image] : input.block.images)
    if (image.position && !is_oriented(input.block, id))
      svg.circle(view(image.position->position_in_world), 3, "lost", image.file);
  for (const auto& [id, pose] : oriented_images(input.block))
    svg.circle(view(centre_of(pose)), count <= 600 ? 2.6 : 1.6, "station", input.block.images.at(id).file);
}

constexpr std::array<int, 7> kOverlapFrom = {1, 2, 3, 4, 5, 7, 9};
constexpr std::array<const char*, 7> kOverlapColours = {"#d7301f", "#fc8d59", "#fdcc8a", "#d9f0d3",
                                                        "#7fcdbb", "#41a6c4", "#225ea8"};

int overlap_class(int images) {
  int found = -1;
  for (std::size_t i = 0; i < kOverlapFrom.size(); ++i)
    if (images >= kOverlapFrom[i]) found = int(i);
  return found;
}

}  // namespace

std::string block_map(const ReportInput& input, const Coverage& coverage, const std::string& unit) {
  MapBounds bounds;
  for (const auto& [id, polygon] : coverage.footprints)
    for (const auto& p : polygon) bounds.add(p);
  for (const auto& [id, pose] : oriented_images(input.block)) bounds.add(centre_of(pose).head<2>());
  for (const auto& [id, point] : input.block.control) bounds.add(point.position_in_world.head<2>());
  const MapView view = bounds.view(kMapWidth, 660);
  Svg svg(view.width, view.height, "Map of the block");
  draw_images(svg, view, input, coverage);
  draw_control(svg, view, input, unit);
  draw_scale_and_north(svg, view, unit);
  return svg.finish();
}

std::string overlap_map(const Overlap& overlap, const std::string& unit) {
  constexpr double kOverlapWidth = 460, kLegend = 46;
  MapBounds bounds;
  bounds.add(overlap.lower_left);
  bounds.add(overlap.lower_left + overlap.cell * Vector2d(overlap.columns, overlap.rows));
  const MapView view = bounds.view(kOverlapWidth, 400);
  Svg svg(view.width, view.height + kLegend, "Overlap");
  const double cell = overlap.cell * view.pixels_per_unit;
  std::array<std::string, kOverlapFrom.size()> outlines;
  for (int row = 0; row < overlap.rows; ++row)
    for (int column = 0; column < overlap.columns;) {
      const auto class_at = [&](int c) {
        return overlap_class(overlap.images[std::size_t(row * overlap.columns + c)]);
      };
      int end = column + 1;
      while (end < overlap.columns && class_at(end) == class_at(column)) ++end;
      if (const int found = class_at(column); found >= 0) {
        const Vector2d at = view(Vector2d(overlap.lower_left + overlap.cell * Vector2d(column, row + 1)));
        outlines[std::size_t(found)] += fmt::format("M{:.1f} {:.1f}h{:.1f}v{:.1f}h{:.1f}z", at.x(), at.y(),
                                                    (end - column) * cell, cell + 0.1, -(end - column) * cell);
      }
      column = end;
    }
  for (std::size_t i = 0; i < outlines.size(); ++i)
    if (!outlines[i].empty()) svg.area(outlines[i], kOverlapColours[i]);
  draw_scale_and_north(svg, view, unit);
  for (std::size_t i = 0; i < kOverlapFrom.size(); ++i) {
    const double x = 10 + 62.0 * double(i), y = view.height + 12;
    svg.rectangle(x, y, 16, 16, "swatch", kOverlapColours[i]);
    const bool last = i + 1 == kOverlapFrom.size();
    const int from = kOverlapFrom[i], to = last ? from : kOverlapFrom[i + 1] - 1;
    svg.text({x + 21, y + 13}, last         ? fmt::format("{}+", from)
                               : from == to ? std::to_string(from)
                                            : fmt::format("{}-{}", from, to));
  }
  return svg.finish();
}

}  // namespace collinea
