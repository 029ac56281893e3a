// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/report/internal/figures.h"
#include "collinea/report/internal/svg.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kWidth = 460, kHeight = 300;

// The axes of a chart of the usual size.
Axis horizontal(double low, double high) { return {low, high, 62, kWidth - 14}; }
Axis vertical(double low, double high) { return {low, high, kHeight - 46, 14}; }

// Radial distortion [px] of a ray whose undistorted image lies at `radius_px` from the principal point.
double radial_distortion_px(const Camera& camera, double radius_px) {
  const auto& p = camera.params;
  const double r = radius_px / p[Camera::kF], r2 = r * r;
  return radius_px * r2 * (p[Camera::kK1] + r2 * (p[Camera::kK2] + r2 * (p[Camera::kK3] + r2 * p[Camera::kK4])));
}

std::vector<Vector2d> distortion_curve(const Camera& camera, double longest_px) {
  std::vector<Vector2d> curve;
  for (int i = 0; i <= 80; ++i) {
    const double radius = longest_px * i / 80;
    curve.emplace_back(radius, radial_distortion_px(camera, radius));
  }
  return curve;
}

void draw_curve(Svg& svg, std::vector<Vector2d> curve, const Axis& x, const Axis& y, std::string_view style) {
  for (Vector2d& p : curve) p = Vector2d(x(p.x()), y(p.y()));
  svg.path(curve, style);
}

}  // namespace

std::string residual_histogram(const ResidualStatistics& statistics) {
  Svg svg(kWidth, kHeight, "Histogram of residuals");
  if (statistics.histogram.empty()) return svg.finish();
  const auto bins = double(statistics.histogram.size());
  const double half = statistics.bin_px * bins / 2, total = 2 * double(statistics.observations);
  double highest = 0;
  for (const std::size_t n : statistics.histogram) highest = std::max(highest, 100 * double(n) / total);
  const double normal_top = 100 * statistics.bin_px / (statistics.rms_px * std::sqrt(2 * std::numbers::pi));
  const Axis x = horizontal(-half, half), y = vertical(0, 1.08 * std::max(highest, std::min(normal_top, 2 * highest)));
  draw_axes(svg, x, y, "residual of a coordinate [px]", "share [%]");
  for (std::size_t i = 0; i < statistics.histogram.size(); ++i) {
    const double from = x(-half + statistics.bin_px * double(i)), to = x(-half + statistics.bin_px * double(i + 1));
    const double top = y(100 * double(statistics.histogram[i]) / total);
    svg.rectangle(from + 0.5, top, to - from - 1, y(0) - top, "bar");
  }
  std::vector<Vector2d> normal;
  for (int i = 0; i <= 100 && statistics.rms_px > 0; ++i) {
    const double value = -half + 2 * half * i / 100, t = value / statistics.rms_px;
    normal.emplace_back(value, normal_top * std::exp(-t * t / 2));
  }
  draw_curve(svg, normal, x, y, "curve second");
  return svg.finish();
}

std::string rays_chart(const ResidualStatistics& statistics) {
  Svg svg(kWidth, kHeight, "Images per tie point");
  double total = 0, highest = 0;
  for (std::size_t i = 2; i < statistics.rays.size(); ++i) total += double(statistics.rays[i]);
  if (total == 0) return svg.finish();
  for (std::size_t i = 2; i < statistics.rays.size(); ++i)
    highest = std::max(highest, 100 * double(statistics.rays[i]) / total);
  const auto last = statistics.rays.size() - 1;
  const Axis x = horizontal(1.5, double(last) + 0.5), y = vertical(0, 1.1 * highest);
  for (const double value : ticks(0, 1.1 * highest, 5)) {
    svg.line({x.pixel_low, y(value)}, {x.pixel_high, y(value)}, "grid");
    svg.text({x.pixel_low - 6, y(value) + 4}, tick_text(value, 1), "end");
  }
  for (std::size_t i = 2; i <= last; ++i) {
    const double share = 100 * double(statistics.rays[i]) / total, at = x(double(i));
    svg.rectangle(at - 15, y(share), 30, y(0) - y(share), "bar");
    svg.text({at, y.pixel_low + 17}, i == last ? fmt::format("{}+", i) : std::to_string(i), "middle");
  }
  svg.line({x.pixel_low, y.pixel_low}, {x.pixel_high, y.pixel_low}, "axis");
  svg.text({(x.pixel_low + x.pixel_high) / 2, kHeight - 12}, "images that see a tie point", "middle");
  svg.vertical_text({16, (y.pixel_low + y.pixel_high) / 2}, "tie points [%]");
  return svg.finish();
}

std::string distortion_chart(const Camera& adjusted, const Camera* first) {
  const auto& p = adjusted.params;
  const double longest = std::hypot(std::max(p[Camera::kCx], adjusted.width_px - p[Camera::kCx]),
                                    std::max(p[Camera::kCy], adjusted.height_px - p[Camera::kCy]));
  const auto after = distortion_curve(adjusted, longest);
  const auto before = first ? distortion_curve(*first, longest) : std::vector<Vector2d>{};
  double low = -1e-3, high = 1e-3;
  for (const auto& curve : {after, before})
    for (const Vector2d& point : curve) {
      low = std::min(low, point.y());
      high = std::max(high, point.y());
    }
  const double room = 0.06 * (high - low);
  Svg svg(kWidth, kHeight, "Radial distortion");
  const Axis x = horizontal(0, longest), y = vertical(low - room, high + room);
  draw_axes(svg, x, y, "distance from the principal point [px]", "radial distortion [px]");
  svg.line({x.pixel_low, y(0)}, {x.pixel_high, y(0)}, "axis");
  draw_curve(svg, before, x, y, "curve second");
  draw_curve(svg, after, x, y, "curve");
  return svg.finish();
}

std::string residual_pattern(const ResidualGrid& grid, const Camera& camera) {
  constexpr int kFewest = 5;  // fewer residuals in a cell say nothing
  const double scale = std::min((kWidth - 20) / camera.width_px, 360.0 / camera.height_px);
  const double width = camera.width_px * scale, height = camera.height_px * scale, left = (kWidth - width) / 2;
  Svg svg(kWidth, height + 50, "Mean residuals over the image");
  svg.rectangle(left, 8, width, height, "frame");
  std::vector<double> lengths;
  for (std::size_t i = 0; i < grid.count.size(); ++i)
    if (grid.count[i] >= kFewest) lengths.push_back(grid.mean_px[i].norm());
  if (lengths.empty()) return svg.finish();
  std::sort(lengths.begin(), lengths.end());
  const double typical = std::max(lengths[lengths.size() * 9 / 10], 1e-6);
  const double cell = width / grid.columns, drawn_per_px = 0.85 * cell / typical;
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const auto i = std::size_t(row * grid.columns + column);
      if (grid.count[i] < kFewest) continue;
      const Vector2d at(left + (column + 0.5) * cell, 8 + (row + 0.5) * height / grid.rows);
      svg.circle(at, 1.2, "dot");
      svg.arrow(at, at + grid.mean_px[i] * std::min(drawn_per_px, 2 * cell / std::max(grid.mean_px[i].norm(), 1e-12)),
                "pattern_arrow");
    }
  const double shown = round_below(typical * 1.2);
  const Vector2d at(left, height + 32);
  svg.arrow(at, at + Vector2d(shown * drawn_per_px, 0), "pattern_arrow");
  svg.text(at + Vector2d(shown * drawn_per_px + 8, 4), fmt::format("{:g} px", shown));
  return svg.finish();
}

}  // namespace collinea
