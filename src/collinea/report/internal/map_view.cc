// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/map_view.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace collinea {

using Eigen::Vector2d;

MapView::MapView(const Vector2d& lowest, const Vector2d& highest, double wanted_width, double most_height)
    : low(lowest), high(highest) {
  const Vector2d size = (high - low).cwiseMax(1e-6);
  pixels_per_unit = std::min((wanted_width - 2 * kMapMargin) / size.x(), (most_height - 2 * kMapMargin) / size.y());
  width = wanted_width;
  height = std::max(220.0, size.y() * pixels_per_unit + 2 * kMapMargin);
}

Vector2d MapView::operator()(const Vector2d& plan) const {
  const Vector2d middle = (low + high) / 2, offset = (plan - middle) * pixels_per_unit;
  return {width / 2 + offset.x(), height / 2 - offset.y()};
}

void MapBounds::add(const Vector2d& p) {
  if (!p.allFinite()) return;
  low_ = low_.cwiseMin(p);
  high_ = high_.cwiseMax(p);
}

MapView MapBounds::view(double width, double most_height) const {
  if (!low_.allFinite()) return {Vector2d::Zero(), Vector2d::Ones(), width, most_height};
  return {low_, high_, width, most_height};
}

std::string scale_text(double length, const std::string& unit) {
  const bool metres = unit == "m";
  if (metres && length < 0.1) return fmt::format("{:g} mm", length * 1000);
  if (metres && length >= 1000) return fmt::format("{:g} km", length / 1000);
  return fmt::format("{:g} {}", length, unit);
}

void draw_scale_and_north(Svg& svg, const MapView& view, const std::string& unit) {
  const double length = round_below(160 / view.pixels_per_unit), px = length * view.pixels_per_unit;
  const Vector2d at(kMapMargin - 14, view.height + view.footer - 18);
  svg.rectangle(at.x() - 6, at.y() - 20, px + 12, 32, "paper");
  svg.line(at, at + Vector2d(px, 0), "scale");
  svg.line(at + Vector2d(0, -4), at + Vector2d(0, 4), "scale");
  svg.line(at + Vector2d(px, -4), at + Vector2d(px, 4), "scale");
  svg.text(at + Vector2d(px / 2, -6), scale_text(length, unit), "middle");
  if (unit != "m") return;
  const Vector2d north(view.width - 26, 16);
  const std::array<Vector2d, 4> needle = {north, north + Vector2d(8, 26), north + Vector2d(0, 20),
                                          north + Vector2d(-8, 26)};
  svg.polygon(needle, "needle");
  svg.text(north + Vector2d(0, 42), "N", "middle");
}

void draw_ellipse(Svg& svg, const Vector2d& at, const Eigen::Matrix2d& covariance_m2, double px_per_m,
                  std::string_view style) {
  if (!covariance_m2.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance_m2);
  const Vector2d axes = px_per_m * eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  constexpr std::size_t kCorners = 32;
  std::array<Vector2d, kCorners> outline;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * double(i) / kCorners;
    const Vector2d p = eigen.eigenvectors() * Vector2d(axes[0] * std::cos(angle), axes[1] * std::sin(angle));
    outline[i] = at + Vector2d(p.x(), -p.y());
  }
  svg.polygon(outline, style);
}

void draw_height_bar(Svg& svg, const Vector2d& at, double sigma_m, double px_per_m, std::string_view style) {
  if (!std::isfinite(sigma_m)) return;
  const Vector2d up(0, -px_per_m * sigma_m), half(3, 0);
  svg.line(at - up, at + up, style);
  for (const Vector2d& end : {Vector2d(at - up), Vector2d(at + up)}) svg.line(end - half, end + half, style);
}

void draw_triangle(Svg& svg, const Vector2d& at, std::string_view style) {
  const std::array<Vector2d, 3> corners = {at + Vector2d(0, -8), at + Vector2d(7, 5), at + Vector2d(-7, 5)};
  svg.polygon(corners, style);
}

}  // namespace collinea
