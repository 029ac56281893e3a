// SPDX-License-Identifier: Apache-2.0
#include "collinea/restitution/measured_figure.h"

#include <Eigen/Geometry>
#include <cmath>
#include <string>

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::RowVectorXd;
using Eigen::Vector3d;

constexpr double kNothing = 1e-12;  // of the size of the figure

// A figure with its derivatives by the positions of its points.
struct Derived {
  double value = 0;
  RowVectorXd by_points;
};

// The points of a figure in their order.
struct Corners {
  std::vector<Vector3d> positions;
  std::vector<double> heights;

  [[nodiscard]] std::size_t count() const { return positions.size(); }
  [[nodiscard]] const Vector3d& at(std::size_t i) const { return positions[i % positions.size()]; }
  [[nodiscard]] double size() const {
    double largest = 0;
    for (const Vector3d& one : positions) largest = std::max(largest, (one - positions[0]).norm());
    return largest;
  }
  [[nodiscard]] Derived nothing() const { return {0, RowVectorXd::Zero(Index(3 * count()))}; }
};

Error coincide() { return Error{Errc::kIllPosed, "points of the figure coincide"}; }

void add(Derived& sum, std::size_t point, const Vector3d& by) {
  sum.by_points.segment<3>(Index(3 * point)) += by.transpose();
}

Result<Derived> length_of(const Corners& corners) {
  Derived out = corners.nothing();
  for (std::size_t i = 0; i + 1 < corners.count(); ++i) {
    const Vector3d way = corners.at(i + 1) - corners.at(i);
    const double length = way.norm();
    if (!(length > kNothing * corners.size())) return tl::unexpected(coincide());
    out.value += length;
    add(out, i + 1, way / length);
    add(out, i, -way / length);
  }
  return out;
}

Derived height_difference(const Corners& corners) {
  Derived out = corners.nothing();
  out.value = corners.heights[1] - corners.heights[0];
  add(out, 1, Vector3d::UnitZ());
  add(out, 0, -Vector3d::UnitZ());
  return out;
}

Result<Derived> plan_distance(const Corners& corners) {
  COLLINEA_TRY(Derived distance, length_of(corners));
  const Derived rise = height_difference(corners);
  const double square = distance.value * distance.value - rise.value * rise.value;
  if (!(square > kNothing * distance.value * distance.value))
    return fail(Errc::kIllPosed, "one point lies above the other: there is no level distance between them");
  const double level = std::sqrt(square);
  distance.by_points = (distance.value * distance.by_points - rise.value * rise.by_points) / level;
  distance.value = level;
  return distance;
}

Result<Derived> slope(const Corners& corners) {
  COLLINEA_TRY(const Derived level, plan_distance(corners));
  const Derived rise = height_difference(corners);
  const double square = level.value * level.value + rise.value * rise.value;
  return Derived{std::atan2(rise.value, level.value),
                 (level.value * rise.by_points - rise.value * level.by_points) / square};
}

// With the unit vector n across both sides: d angle = (n x a) . da / a^2 of the first, minus that of the other.
Result<Derived> angle(const Corners& corners) {
  const Vector3d a = corners.at(0) - corners.at(1), b = corners.at(2) - corners.at(1), across = a.cross(b);
  const double size = kNothing * corners.size();
  if (!(a.norm() > size) || !(b.norm() > size)) return tl::unexpected(coincide());
  if (!(across.norm() > 1e-9 * a.norm() * b.norm()))
    return fail(Errc::kIllPosed,
                "the two sides of the angle lie in one line: its standard deviation is of second order");
  const Vector3d n = across.normalized();
  Derived out = corners.nothing();
  out.value = std::atan2(across.norm(), a.dot(b));
  const Vector3d by_a = -n.cross(a) / a.squaredNorm(), by_b = n.cross(b) / b.squaredNorm();
  add(out, 0, by_a);
  add(out, 2, by_b);
  add(out, 1, -by_a - by_b);
  return out;
}

// Half the sum of cross products is the vector of a polygon's area; `axis`: along which it counts, or nothing.
Result<Derived> area(const Corners& corners, const std::optional<Vector3d>& axis) {
  Vector3d vector = Vector3d::Zero();
  for (std::size_t i = 0; i < corners.count(); ++i)
    vector += 0.5 * (corners.at(i) - corners.at(0)).cross(corners.at(i + 1) - corners.at(0));
  const double along = axis ? vector.dot(*axis) : vector.norm();
  if (!(std::abs(along) > kNothing * corners.size() * corners.size()))
    return fail(Errc::kIllPosed, "the polygon has no area");
  const Vector3d normal = axis ? Vector3d(std::copysign(1.0, along) * *axis) : Vector3d(vector / along);
  Derived out = corners.nothing();
  out.value = std::abs(along);
  for (std::size_t i = 0; i < corners.count(); ++i) {
    const Vector3d chord = corners.at(i + 1) - corners.at(i + corners.count() - 1);
    add(out, i, 0.5 * chord.cross(normal));
  }
  return out;
}

Result<Derived> derived(FigureKind kind, const Corners& corners) {
  switch (kind) {
    case FigureKind::kDistance:
    case FigureKind::kLength:
      return length_of(corners);
    case FigureKind::kPlanDistance:
      return plan_distance(corners);
    case FigureKind::kHeightDifference:
      return height_difference(corners);
    case FigureKind::kSlope:
      return slope(corners);
    case FigureKind::kAngle:
      return angle(corners);
    case FigureKind::kArea:
      return area(corners, std::nullopt);
    case FigureKind::kPlanArea:
      return area(corners, Vector3d::UnitZ());
  }
  return fail(Errc::kBadInput, "no such figure");
}

}  // namespace

std::string_view unit_of(FigureKind kind) {
  switch (kind) {
    case FigureKind::kArea:
    case FigureKind::kPlanArea:
      return "m2";
    case FigureKind::kSlope:
    case FigureKind::kAngle:
      return "rad";
    default:
      return "m";
  }
}

FigureSize size_of(FigureKind kind) {
  switch (kind) {
    case FigureKind::kAngle:
      return {3, false};
    case FigureKind::kLength:
      return {2, true};
    case FigureKind::kArea:
    case FigureKind::kPlanArea:
      return {3, true};
    default:
      return {2, false};
  }
}

Result<MeasuredFigure> measure_figure(FigureKind kind, std::span<const std::size_t> numbers,
                                      const FigurePoints& points) {
  const FigureSize size = size_of(kind);
  if (numbers.size() < size.count || (!size.is_least && numbers.size() > size.count))
    return fail(Errc::kBadInput, std::string(word_of(kind)) + " is of " + std::to_string(size.count) + " points" +
                                     (size.is_least ? " or more" : "") + ", not of " + std::to_string(numbers.size()));
  const bool is_exact = points.covariance.size() == 0;
  COLLINEA_CHECK(is_exact || points.covariance.rows() == Index(3 * points.positions.size()));
  Corners corners;
  for (const std::size_t number : numbers) {
    if (number >= points.positions.size()) return fail(Errc::kBadInput, "the figure has a point that there is not");
    corners.positions.push_back(points.positions[number]);
    corners.heights.push_back(points.heights.empty() ? points.positions[number].z() : points.heights[number]);
  }
  COLLINEA_TRY(const Derived figure, derived(kind, corners));
  if (is_exact) return MeasuredFigure{figure.value, 0};
  // A point may stand in the figure more than once.
  RowVectorXd by_all = RowVectorXd::Zero(points.covariance.rows());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    by_all.segment<3>(Index(3 * numbers[i])) += figure.by_points.segment<3>(Index(3 * i));
  const double variance = (by_all * points.covariance * by_all.transpose()).value();
  return MeasuredFigure{figure.value, std::sqrt(std::max(variance, 0.0))};
}

}  // namespace collinea
