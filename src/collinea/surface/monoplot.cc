// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/monoplot.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kStep = 0.25;          // of a cell, along the ray in plan
constexpr double kPixelStep_px = 0.01;  // of a derivative
constexpr int kMargin = 3;              // cells round a window

using Ray = SurfaceRay;
using Span = HeightSpan;

// The part of a ray in the box of the surface; empty: first > last.
struct Part {
  double first = 0, last = std::numeric_limits<double>::infinity();

  void clip(double from, double direction, double low, double high) {
    if (direction == 0) {
      if (from < low || from > high) last = -1;
      return;
    }
    const double a = (low - from) / direction, b = (high - from) / direction;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
};

// Heights of the cells under a piece of a ray.
struct Window {
  const MapGrid* grid = nullptr;
  int column = 0, row = 0;
  FloatImage heights_m;

  [[nodiscard]] double cell(int x, int y) const {
    const int c = x - column, r = y - row;
    return c < 0 || r < 0 || c >= heights_m.width || r >= heights_m.height ? kNone : double(heights_m.at(c, r));
  }
  // Bilinear between the middles of cells; NaN beside a cell without a height.
  [[nodiscard]] double height(double east_m, double north_m) const {
    const double x = grid->column_of(east_m) - 0.5, y = grid->row_of(north_m) - 0.5;
    const int c = int(std::floor(x)), r = int(std::floor(y));
    const double u = x - c, v = y - r;
    double sum = 0;
    for (int k = 0; k < 4; ++k) {
      const double weight = (k & 1 ? u : 1 - u) * (k & 2 ? v : 1 - v);
      if (weight > 0) sum += weight * cell(c + (k & 1), r + (k >> 1));
    }
    return sum;
  }
  // Slopes over 3 x 3 cells (Horn); those between the nearest two cells that have heights at a border.
  [[nodiscard]] Vector2d slope(double east_m, double north_m) const {
    const int x = int(std::floor(grid->column_of(east_m))), y = int(std::floor(grid->row_of(north_m)));
    const double middle = height(east_m, north_m);
    const auto near = [&](int dx, int dy) {
      const double value = cell(x + dx, y + dy);
      return std::isfinite(value) ? value : middle;
    };
    const auto sum = [&](int a, int b, bool along_x) {
      return along_x ? near(a, -1) + 2 * near(a, 0) + near(a, 1) - near(b, -1) - 2 * near(b, 0) - near(b, 1)
                     : near(-1, a) + 2 * near(0, a) + near(1, a) - near(-1, b) - 2 * near(0, b) - near(1, b);
    };
    return Vector2d(sum(1, -1, true), sum(-1, 1, false)) / (8 * grid->cell_m);
  }
};

Ray ray_of(const SightLine& line, const Vector2d& pixel) {
  return {centre_of(line.cam_from_world),
          line.cam_from_world.rotation.conjugate() * normalized(*line.camera, pixel).homogeneous()};
}

Part part_of(const Ray& ray, const MapGrid& grid, const Span& span) {
  Part part;
  const double half = 0.5 * (1 + 1e-9) * grid.cell_m;  // heights are known between the middles of cells
  part.clip(ray.centre.x(), ray.direction.x(), grid.west_m + half, grid.east_of(grid.width) - half);
  part.clip(ray.centre.y(), ray.direction.y(), grid.north_of(grid.height) + half, grid.north_m - half);
  const double above = 1e-6 + 1e-6 * std::abs(span.high);
  part.clip(ray.centre.z(), ray.direction.z(), span.low - above, span.high + above);
  return part;
}

Result<Window> window_under(const Ray& ray, const Part& part, const HeightField& surface) {
  const MapGrid& grid = surface.grid;
  const Vector3d a = ray.at(part.first), b = ray.at(part.last);
  Window window{&grid, 0, 0, {}};
  const auto cells = [&](double one, double two, int count) {
    const int first = std::clamp(int(std::floor(std::min(one, two))) - kMargin, 0, count - 1);
    const int last = std::clamp(int(std::ceil(std::max(one, two))) + kMargin, first + 1, count);
    return std::pair(first, last - first);
  };
  const auto [column, width] = cells(grid.column_of(a.x()), grid.column_of(b.x()), grid.width);
  const auto [row, height] = cells(grid.row_of(a.y()), grid.row_of(b.y()), grid.height);
  window.column = column;
  window.row = row;
  COLLINEA_TRY(window.heights_m, surface.read(column, row, width, height));
  return window;
}

// Where a ray crosses the surface, with the heights there.
struct Crossing {
  MonoplotOutcome outcome = MonoplotOutcome::kMisses;
  double t = 0;
  Window window = {};
};

// Follows the ray until it is below the surface.
Result<Crossing> crossing(const Ray& ray, const Part& part, const HeightField& surface) {
  constexpr long kStepsOfPiece = 1024;  // 256 cells
  const double length = (ray.at(part.last) - ray.at(part.first)).head<2>().norm();
  if (length > kMostCellsAlongRay * surface.grid.cell_m)
    return fail(Errc::kUnsupported, "the ray runs too flat over the surface to be followed");
  const auto steps = std::max<long>(1, long(std::ceil(length / (kStep * surface.grid.cell_m))));
  const auto t_of = [&](long k) { return part.first + (part.last - part.first) * double(k) / double(steps); };
  Window window;
  const auto above = [&](double t) {
    const Vector3d at = ray.at(t);
    return at.z() - window.height(at.x(), at.y());
  };
  double before = part.first, was = kNone;
  bool has_gap = false;
  for (long k = 0; k <= steps; ++k) {
    if (k % kStepsOfPiece == 0) {  // with the step before it, from which a crossing is looked for
      const Part piece{t_of(std::max(k - 1, 0L)), t_of(std::min(k + kStepsOfPiece, steps))};
      COLLINEA_TRY(window, window_under(ray, piece, surface));
    }
    const double t = t_of(k), is = above(t);
    if (!std::isfinite(is)) {
      has_gap |= std::isfinite(was);
      continue;
    }
    if (is <= 0) {
      if (!std::isfinite(was)) return Crossing{k == 0 ? MonoplotOutcome::kBelow : MonoplotOutcome::kHole, t};
      if (has_gap) return Crossing{MonoplotOutcome::kHole, t};
      double low = before, high = t;  // above and below
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (above(middle) > 0 ? low : high) = middle;
      }
      return Crossing{MonoplotOutcome::kFound, 0.5 * (low + high), std::move(window)};
    }
    before = t;
    was = is;
    has_gap = false;
  }
  return Crossing{has_gap || !std::isfinite(was) ? MonoplotOutcome::kHole : MonoplotOutcome::kMisses};
}

// Of the height of the cell there; `otherwise`: the surface states none anywhere.
Result<double> sigma_at(const HeightField& surface, const Vector3d& position, double otherwise) {
  if (!surface.read_sigma) return otherwise;
  const MapGrid& grid = surface.grid;
  const int column = int(std::floor(grid.column_of(position.x()))), row = int(std::floor(grid.row_of(position.y())));
  if (column < 0 || row < 0 || column >= grid.width || row >= grid.height) return kNone;
  COLLINEA_TRY(const FloatImage cell, surface.read_sigma(column, row, 1, 1));
  return double(cell.at(0, 0));
}

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d out;
  out << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return out;
}

// The point with its covariance; `sigma` of the height, 0: exact.
MonoplotPoint point_at(const UncertainSightLine& given, const Ray& ray, double t, const Vector2d& slope, double sigma) {
  const SightLine& line = given.line;
  MonoplotPoint point{.outcome = MonoplotOutcome::kFound, .position = ray.at(t), .height_sigma_m = sigma};
  const Vector3d normal(-slope.x(), -slope.y(), 1);
  const double along = normal.dot(ray.direction);
  point.angle_rad = std::asin(std::min(std::abs(along) / (normal.norm() * ray.direction.norm()), 1.0));
  if (!(point.angle_rad > kLeastMeetingAngle_rad)) {
    point.outcome = MonoplotOutcome::kGrazes;
    return point;
  }
  Eigen::Matrix<double, 3, 2> by_pixel;
  for (int k = 0; k < 2; ++k) {
    const Vector2d step = kPixelStep_px * Vector2d::Unit(k);
    by_pixel.col(k) = (ray_of(line, line.pixel + step).direction - ray_of(line, line.pixel - step).direction) *
                      (t / (2 * kPixelStep_px));
  }
  Eigen::Matrix<double, 3, 6> by_pose;
  by_pose << -t * cross_matrix(ray.direction), Matrix3d::Identity();
  const Matrix3d onto = Matrix3d::Identity() - ray.direction * normal.transpose() / along;
  const Vector3d by_height = ray.direction / along;
  point.covariance = onto *
                         (line.sigma_px * line.sigma_px * by_pixel * by_pixel.transpose() +
                          by_pose * given.pose_covariance * by_pose.transpose()) *
                         onto.transpose() +
                     sigma * sigma * by_height * by_height.transpose();
  return point;
}

Result<MonoplotPoint> plotted(const UncertainSightLine& line, const HeightField& surface, const Span& span,
                              std::optional<double> sigma_m) {
  const Ray ray = ray_of(line.line, line.line.pixel);
  if (!ray.direction.allFinite()) return MonoplotPoint{};
  COLLINEA_TRY(const SurfaceMeeting met, meeting(ray, surface, span, sigma_m));
  if (met.outcome != MonoplotOutcome::kFound) return MonoplotPoint{.outcome = met.outcome};
  return point_at(line, ray, met.t, met.slope, met.sigma_m);
}

}  // namespace

Result<HeightSpan> height_span(const HeightField& surface, const Run& run) {
  COLLINEA_TRY(const HeightOverview blocks, overview(surface, run));
  Span span{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const float low : blocks.lowest_m.data)
    if (std::isfinite(low)) span.low = std::min(span.low, double(low));
  for (const float high : blocks.highest_m.data)
    if (std::isfinite(high)) span.high = std::max(span.high, double(high));
  if (!(span.low <= span.high)) return fail(Errc::kBadInput, "the surface has no heights");
  return span;
}

Result<SurfaceMeeting> meeting(const SurfaceRay& ray, const HeightField& surface, const HeightSpan& span,
                               std::optional<double> sigma_m) {
  const Part part = part_of(ray, surface.grid, span);
  if (!(part.first <= part.last)) return SurfaceMeeting{};
  COLLINEA_TRY(const Crossing at, crossing(ray, part, surface));
  if (at.outcome != MonoplotOutcome::kFound) return SurfaceMeeting{.outcome = at.outcome};
  const Vector3d position = ray.at(at.t);
  COLLINEA_TRY(double sigma, sigma_at(surface, position, sigma_m.value_or(0)));
  if (!std::isfinite(sigma)) sigma = sigma_m.value_or(kNone);
  return SurfaceMeeting{at.outcome, at.t, at.window.slope(position.x(), position.y()), sigma};
}

Result<std::vector<MonoplotPoint>> monoplot(std::span<const UncertainSightLine> lines, const HeightField& surface,
                                            std::optional<double> sigma_m, const Run& run) {
  COLLINEA_TRY(const Span span, height_span(surface, run));
  std::vector<MonoplotPoint> points;
  for (const UncertainSightLine& line : lines) {
    COLLINEA_TRY(MonoplotPoint point, plotted(line, surface, span, sigma_m));
    points.push_back(point);
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  }
  return points;
}

}  // namespace collinea
