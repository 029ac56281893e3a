// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/report/internal/map_view.h"
#include "collinea/report/plan_report.h"
#include "collinea/report/plan_words.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

void draw_area(Svg& svg, const MapView& view, const MapArea& area, std::string_view style) {
  std::vector<Vector2d> outline;
  for (const Vector2d& corner : area) outline.push_back(view(corner));
  svg.polygon(outline, style);
}

void draw_points(Svg& svg, const MapView& view, const PlanReport& report, bool names) {
  for (const PlannedPoint& point : report.points) {
    const Vector2d at = view(point.position);
    if (point.role == ControlRole::kControl)
      draw_triangle(svg, at, "control");
    else
      svg.circle(at, 6, "check", point.name);
    svg.circle(at, 1, "dot");
    if (names) svg.text(at + Vector2d(9, 14), point.name, "start", "label halo");
  }
  for (const Gain& gain : report.gains) {
    if (!gain.position) continue;
    svg.circle(view(*gain.position), 9, "more", words_of(gain));
    if (names) svg.text(view(*gain.position) + Vector2d(12, 4), words_of(gain), "start", "label halo");
  }
}

// A round number of classes between the least and the largest value; differences below a tenth are not worth a colour.
struct Classes {
  double low = 0, step = 1;
  std::size_t count = 1;

  explicit Classes(std::vector<double> values) {
    if (values.empty()) return;
    std::sort(values.begin(), values.end());
    const double least = values.front(), most = values[values.size() - 1 - values.size() / 200];
    const double wanted = std::max((most - least) / (kColours.size() - 1), 0.1 * values[values.size() / 2]);
    step = round_below(wanted);
    if (step < wanted) step = step * 2 >= wanted ? step * 2 : round_below(step * 5.01);
    if (step < wanted) step *= 2;
    low = std::floor(least / step) * step;
    count = std::min(kColours.size(), std::size_t(std::floor((most - low) / step)) + 1);
  }
  [[nodiscard]] std::size_t operator()(double value) const {
    return std::min(count - 1, std::size_t(std::max(0.0, std::floor((value - low) / step))));
  }
  static constexpr std::array<const char*, 7> kColours = {"#2166ac", "#67a9cf", "#b8dbe8", "#f2eec4",
                                                          "#fdc77f", "#ef8a62", "#b2182b"};
};

// Millimetres read better than 0.0012 m.
std::string class_text(double low_m, double high_m, bool open) {
  const bool mm = high_m < 0.1;
  const double unit = mm ? 1000 : 1, step = (high_m - low_m) * unit;
  const int decimals = step >= 1 ? 0 : step >= 0.1 ? 1 : 2;
  return number_text(low_m * unit, decimals) + (open ? "+" : "\xe2\x80\x93" + number_text(high_m * unit, decimals)) +
         (mm ? " mm" : " m");
}

void draw_legend(Svg& svg, const Classes& classes, double top) {
  for (std::size_t i = 0; i < classes.count; ++i) {
    const double x = 10 + 112.0 * double(i % 4), y = top + 22.0 * double(i / 4);
    svg.rectangle(x, y, 16, 16, "swatch", Classes::kColours[i]);
    const double low = classes.low + double(i) * classes.step;
    svg.text({x + 21, y + 13}, class_text(low, low + classes.step, i + 1 == Classes::kColours.size()));
  }
}

// Cells about a fifth of the area apart: as many ellipses as can be told from each other.
std::vector<const CellPrecision*> few_cells(const Precision& precision) {
  const PrecisionGrid& grid = precision.planned.grid;
  const int step = std::max(1, int(std::lround(std::max(grid.width, grid.height) / 8.0)));
  const auto chosen = [&](int i, int count) { return (i - (count - 1) / 2) % step == 0; };
  std::vector<const CellPrecision*> cells;
  for (const CellPrecision& cell : precision.cells)
    if (chosen(int(cell.cell % std::size_t(grid.width)), grid.width) &&
        chosen(int(cell.cell / std::size_t(grid.width)), grid.height))
      cells.push_back(&cell);
  return cells;
}

void draw_ellipses(Svg& svg, const MapView& view, const Precision& precision) {
  constexpr double kLongest_px = 26;
  const std::vector<const CellPrecision*> cells = few_cells(precision);
  double longest = 0;
  for (const CellPrecision* cell : cells) longest = std::max({longest, cell->plan_m(), cell->sigma_m().z()});
  if (!(longest > 0)) return;
  const double px_per_m = kLongest_px / longest;
  for (const CellPrecision* cell : cells) {
    draw_ellipse(svg, view(cell->position), cell->covariance_m2.topLeftCorner<2, 2>(), px_per_m, "ellipse");
    draw_height_bar(svg, view(cell->position), cell->sigma_m().z(), px_per_m, "height_bar");
  }
  const double length = round_below(longest), px = length * px_per_m;
  const Vector2d corner(view.width - 250, view.height + view.footer - 22);
  svg.rectangle(corner.x() - 34, corner.y() - 24, 280, 46, "paper");
  draw_ellipse(svg, corner, length * length * Eigen::Matrix2d::Identity(), px_per_m, "ellipse");
  svg.text(corner + Vector2d(px + 8, 4), "plan, " + scale_text(length, "m"));
  draw_height_bar(svg, corner + Vector2d(130, 0), length, px_per_m, "height_bar");
  svg.text(corner + Vector2d(140, 4), "height, " + scale_text(length, "m"));
}

}  // namespace

std::string plan_map(const PlanReport& report) {
  MapBounds bounds;
  for (const Vector2d& corner : report.plan.area) bounds.add(corner);
  for (const PlannedImage& image : report.plan.images) bounds.add(image.centre.head<2>());
  for (const PlannedPoint& point : report.points) bounds.add(point.position);
  MapView view = bounds.view(kMapWidth, 620);
  view.footer = 30;
  Svg svg(view.width, view.height + view.footer, "Flight, control and precision");
  draw_area(svg, view, report.plan.area, "site");
  std::vector<Vector2d> line;
  for (std::size_t i = 0; i < report.plan.images.size(); ++i) {
    line.push_back(view(report.plan.images[i].centre));
    const bool last = i + 1 == report.plan.images.size();
    if (!last && report.plan.images[i + 1].strip == report.plan.images[i].strip) continue;
    svg.path(line, report.plan.images[i].cross ? "flight cross" : "flight");
    line.clear();
  }
  for (const PlannedImage& image : report.plan.images) svg.circle(view(image.centre), 1.6, "station");
  draw_ellipses(svg, view, report.precision);
  draw_points(svg, view, report, true);
  draw_scale_and_north(svg, view, "m");
  return svg.finish();
}

std::string sigma_map(const PlanReport& report, bool height) {
  constexpr double kWidth = 460, kLegend = 50;
  const Precision& precision = report.precision;
  const auto sigma = [&](const CellPrecision& cell) { return height ? cell.sigma_m().z() : cell.plan_m(); };
  MapBounds bounds;
  for (const Vector2d& corner : report.plan.area) bounds.add(corner);
  const MapView view = bounds.view(kWidth, 420);
  std::vector<double> values;
  for (const CellPrecision& cell : precision.cells) values.push_back(sigma(cell));
  const Classes classes(values);
  Svg svg(view.width, view.height + kLegend, height ? "Standard deviation of heights" : "Standard deviation in plan");
  const double half = precision.planned.grid.cell_m / 2, px = 2 * half * view.pixels_per_unit;
  for (const CellPrecision& cell : precision.cells) {
    const Vector2d at = view(Vector2d(cell.position + Vector2d(-half, half)));
    svg.rectangle(at.x(), at.y(), px + 0.3, px + 0.3, "cell", Classes::kColours[classes(sigma(cell))]);
  }
  draw_area(svg, view, report.plan.area, "site outline");
  draw_points(svg, view, report, false);
  draw_scale_and_north(svg, view, "m");
  draw_legend(svg, classes, view.height + 6);
  return svg.finish();
}

}  // namespace collinea
