// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/internal/solid.h"

#include <cmath>
#include <limits>

namespace collinea {
namespace {

// The part of a line inside an intersection of half spaces.
struct Span {
  double enter = -std::numeric_limits<double>::infinity(), leave = std::numeric_limits<double>::infinity();
  int face = -1;

  // Keeps what satisfies rate t <= room.
  void clip(double rate, double room, int which) {
    if (rate < 0) {
      const double t = room / rate;
      if (t > enter) {
        enter = t;
        face = which;
      }
    } else if (rate > 0) {
      leave = std::min(leave, room / rate);
    } else if (room < 0) {
      leave = -std::numeric_limits<double>::infinity();
    }
  }
  [[nodiscard]] bool empty() const { return !(enter < leave); }
};

// A line in the body's own frame: u along its length, v across.
struct Line {
  double u, v, du, dv;
};

Line in_body(const Solid& s, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const double x = origin.x() - s.x, y = origin.y() - s.y;
  return {s.cosine * x + s.sine * y, s.cosine * y - s.sine * x,  //
          s.cosine * direction.x() + s.sine * direction.y(), s.cosine * direction.y() - s.sine * direction.x()};
}

void clip_round(Span& span, const Line& l, double radius) {
  const double a = l.du * l.du + l.dv * l.dv, b = l.u * l.du + l.v * l.dv, c = l.u * l.u + l.v * l.v - radius * radius;
  const double discriminant = b * b - a * c;
  if (a == 0 ? c > 0 : discriminant <= 0) {
    span.leave = -std::numeric_limits<double>::infinity();
  } else if (a > 0) {
    const double root = std::sqrt(discriminant);
    span.enter = (-b - root) / a;
    span.leave = (-b + root) / a;
    span.face = Solid::kEnd;
  }
}

// Middle and half the height of a crown.
double middle_m(const Solid& s) { return 0.5 * (s.bottom_m + s.ridge_m); }
double half_height_m(const Solid& s) { return 0.5 * (s.ridge_m - s.bottom_m); }

// In the space where the crown is the unit sphere: from the point of the line that is nearest to its centre.
std::optional<SolidHit> meet_crown(const Solid& s, const Line& l, double z, double dz) {
  const double r = s.half_length_m, h = half_height_m(s);
  const Eigen::Vector3d from(l.u / r, l.v / r, (z - middle_m(s)) / h), along(l.du / r, l.dv / r, dz / h);
  const double square = along.squaredNorm(), nearest = -from.dot(along) / square;
  const double inside = 1 - (from + nearest * along).squaredNorm();
  if (inside <= 0) return std::nullopt;
  const double t = nearest - std::sqrt(inside / square);
  if (!(t > 0)) return std::nullopt;
  return SolidHit{t, Solid::kRoof};
}

double slope_of(const Solid& s) {
  return s.shape == Solid::Shape::kGable ? (s.ridge_m - s.eave_m) / s.half_width_m : 0;
}

}  // namespace

double Solid::radius_m() const { return is_round() ? half_length_m : std::hypot(half_length_m, half_width_m); }

std::optional<SolidHit> meet(const Solid& s, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const Line l = in_body(s, origin, direction);
  if (s.shape == Solid::Shape::kCrown) return meet_crown(s, l, origin.z(), direction.z());
  Span span;
  if (s.shape == Solid::Shape::kColumn) {
    clip_round(span, l, s.half_length_m);
    if (span.empty()) return std::nullopt;
  } else {
    span.clip(l.du, s.half_length_m - l.u, Solid::kEnd);
    span.clip(-l.du, s.half_length_m + l.u, Solid::kOtherEnd);
    if (span.empty()) return std::nullopt;
    span.clip(l.dv, s.half_width_m - l.v, Solid::kSide);
    span.clip(-l.dv, s.half_width_m + l.v, Solid::kOtherSide);
    if (span.empty()) return std::nullopt;
  }
  span.clip(-direction.z(), origin.z() - s.bottom_m, Solid::kBottom);
  if (s.shape == Solid::Shape::kGable) {  // z + slope |v| <= ridge
    const double slope = slope_of(s), room = s.ridge_m - origin.z();
    span.clip(direction.z() + slope * l.dv, room - slope * l.v, Solid::kRoof);
    span.clip(direction.z() - slope * l.dv, room + slope * l.v, Solid::kOtherRoof);
  } else {
    span.clip(direction.z(), s.eave_m - origin.z(), Solid::kRoof);
  }
  if (span.empty() || !(span.enter > 0)) return std::nullopt;
  return SolidHit{span.enter, span.face};
}

Eigen::Vector3d normal_of(const Solid& s, int face, const Eigen::Vector3d& point) {
  const Eigen::Vector3d along(s.cosine, s.sine, 0), across(-s.sine, s.cosine, 0);
  if (s.shape == Solid::Shape::kColumn && face == Solid::kEnd)
    return Eigen::Vector3d(point.x() - s.x, point.y() - s.y, 0).normalized();
  if (s.shape == Solid::Shape::kCrown) {
    const double r2 = s.half_length_m * s.half_length_m, h = half_height_m(s);
    return Eigen::Vector3d((point.x() - s.x) / r2, (point.y() - s.y) / r2, (point.z() - middle_m(s)) / (h * h))
        .normalized();
  }
  switch (face) {
    case Solid::kEnd:
      return along;
    case Solid::kOtherEnd:
      return -along;
    case Solid::kSide:
      return across;
    case Solid::kOtherSide:
      return -across;
    case Solid::kBottom:
      return -Eigen::Vector3d::UnitZ();
    case Solid::kRoof:
      return (Eigen::Vector3d::UnitZ() + slope_of(s) * across).normalized();
    default:
      return (Eigen::Vector3d::UnitZ() - slope_of(s) * across).normalized();
  }
}

std::optional<double> top_at(const Solid& s, double x, double y) {
  const Line l = in_body(s, {x, y, 0}, Eigen::Vector3d::UnitZ());
  if (s.shape == Solid::Shape::kColumn)
    return l.u * l.u + l.v * l.v <= s.half_length_m * s.half_length_m ? std::optional(s.eave_m) : std::nullopt;
  if (s.shape == Solid::Shape::kCrown) {
    const double inside = 1 - (l.u * l.u + l.v * l.v) / (s.half_length_m * s.half_length_m);
    return inside > 0 ? std::optional(middle_m(s) + half_height_m(s) * std::sqrt(inside)) : std::nullopt;
  }
  if (std::abs(l.u) > s.half_length_m || std::abs(l.v) > s.half_width_m) return std::nullopt;
  return s.shape == Solid::Shape::kGable ? s.ridge_m - slope_of(s) * std::abs(l.v) : s.eave_m;
}

Eigen::Vector2d face_coordinates(const Solid& s, int face, const Eigen::Vector3d& point) {
  const Line l = in_body(s, point, Eigen::Vector3d::UnitZ());
  if (s.shape == Solid::Shape::kColumn && face == Solid::kEnd)
    return {std::atan2(l.v, l.u) * s.half_length_m, point.z()};
  // Leaves: a section through all three coordinates, so that steep sides are not drawn out.
  if (s.shape == Solid::Shape::kCrown) return {l.u + 0.6 * point.z(), l.v - 0.8 * point.z()};
  if (face == Solid::kEnd || face == Solid::kOtherEnd) return {l.v, point.z()};
  if (face == Solid::kSide || face == Solid::kOtherSide) return {l.u, point.z()};
  if (s.shape == Solid::Shape::kGable && face >= Solid::kRoof)
    return {l.u, std::abs(l.v) * std::sqrt(1 + slope_of(s) * slope_of(s))};
  return {l.u, l.v};
}

}  // namespace collinea
