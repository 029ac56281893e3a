// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/line_corners.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

double distance_from_points(const FoundLine& line, std::span<const EdgePoint> points, const Vector2d& p) {
  double least2 = INFINITY;
  for (const std::size_t i : line.points) least2 = std::min(least2, (points[i].at - p).squaredNorm());
  return std::sqrt(least2);
}

// A point outside the piece between its outermost points by more than that needs no look at all of them.
bool is_beside(const EdgeLine& line, const Vector2d& p, double reach_px) {
  const Vector2d middle = (line.from + line.to) / 2;
  return (p - middle).norm() > line.length_px() / 2 + reach_px + 2;
}

// Variance of the line's distance from a point that lies on it.
double variance_at(const EdgeLine& line, const Vector2d& p) {
  const double t = Vector2d(-std::sin(line.theta_rad), std::cos(line.theta_rad)).dot(p);
  const Matrix2d& c = line.covariance;
  return c(1, 1) - 2 * t * c(0, 1) + t * t * c(0, 0);
}

std::optional<LineCorner> corner_of(const FoundLine& first, const FoundLine& second, std::span<const EdgePoint> points,
                                    const LineCornerOptions& o) {
  const EdgeLine &a = first.line, &b = second.line;
  Matrix2d normals;
  normals.row(0) = a.normal().transpose();
  normals.row(1) = b.normal().transpose();
  const double sine = std::min(1.0, std::abs(normals.determinant()));
  LineCorner corner;
  corner.angle_rad = std::asin(sine);
  if (corner.angle_rad < o.least_angle_deg * std::numbers::pi / 180) return std::nullopt;
  const Matrix2d inverse = normals.inverse();
  corner.at = inverse * Vector2d(a.r_px, b.r_px);
  if (is_beside(a, corner.at, o.reach_px) || is_beside(b, corner.at, o.reach_px)) return std::nullopt;
  corner.gap_px =
      std::max(distance_from_points(first, points, corner.at), distance_from_points(second, points, corner.at));
  if (!(corner.gap_px <= o.reach_px)) return std::nullopt;
  const Vector2d variances(variance_at(a, corner.at), variance_at(b, corner.at));
  corner.covariance = inverse * variances.asDiagonal() * inverse.transpose();
  return corner;
}

}  // namespace

std::vector<LineCorner> line_corners(std::span<const FoundLine> lines, std::span<const EdgePoint> points,
                                     const LineCornerOptions& options) {
  std::vector<LineCorner> out;
  for (std::size_t i = 0; i < lines.size(); ++i)
    for (std::size_t j = i + 1; j < lines.size(); ++j)
      if (auto corner = corner_of(lines[i], lines[j], points, options)) {
        corner->first = i;
        corner->second = j;
        out.push_back(*corner);
      }
  return out;
}

}  // namespace collinea
