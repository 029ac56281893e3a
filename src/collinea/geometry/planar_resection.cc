// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/planar_resection.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "collinea/geometry/circle_fit.h"
#include "collinea/math/least_median.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

double around_zero(double angle) { return std::remainder(angle, 2 * kPi); }

double cotangent(double angle) {
  const double sine = std::sin(angle);
  return std::cos(angle) / (std::abs(sine) > 1e-9 ? sine : std::copysign(1e-9, sine));
}

// The point common to the circles over two pairs of three points (Pierlot and Van Droogenbroeck 2014).
std::optional<Vector2d> of_three(const PlanarDirection& a, const PlanarDirection& b, const PlanarDirection& c) {
  const double t12 = cotangent(a.direction_rad - b.direction_rad), t23 = cotangent(b.direction_rad - c.direction_rad);
  const double sum = t12 + t23;
  const double t31 = (1 - t12 * t23) / (std::abs(sum) > 1e-12 ? sum : 1e-12);
  const Vector2d p = a.to - b.to, q = c.to - b.to;
  const Vector2d c12(p.x() + t12 * p.y(), p.y() - t12 * p.x()), c23(q.x() - t23 * q.y(), q.y() + t23 * q.x());
  const Vector2d c31(q.x() + p.x() + t31 * (q.y() - p.y()), q.y() + p.y() - t31 * (q.x() - p.x()));
  const double k31 = p.dot(q) + t31 * (p.x() * q.y() - q.x() * p.y());
  const double d = (c12.x() - c23.x()) * (c23.y() - c31.y()) - (c12.y() - c23.y()) * (c23.x() - c31.x());
  // The three circles coincide: the station is on the danger circle.
  constexpr double kCoincide = 1e-18;  // the station within a millionth of the radius
  if (!(std::abs(d) > kCoincide * (c12.squaredNorm() + c23.squaredNorm()))) return std::nullopt;
  const Vector2d station = b.to + k31 / d * Vector2d(c12.y() - c23.y(), c23.x() - c12.x());
  if (!station.allFinite()) return std::nullopt;
  return station;
}

double azimuth(const Vector2d& from, const Vector2d& to) { return std::atan2(to.x() - from.x(), to.y() - from.y()); }

// The azimuth of zero that suits best: the mean direction of what the single ones give.
double orientation_at(std::span<const PlanarDirection> directions, const Vector2d& station) {
  Vector2d sum = Vector2d::Zero();
  for (const PlanarDirection& one : directions) {
    const double zero = azimuth(station, one.to) - one.direction_rad;
    sum += Vector2d(std::cos(zero), std::sin(zero)) / (one.sigma_rad * one.sigma_rad);
  }
  return std::atan2(sum.y(), sum.x());
}

// Misfits over their sigmas and the rows of the design.
double linearise(std::span<const PlanarDirection> directions, const Vector2d& station, double orientation,
                 std::vector<Vector3d>& rows, std::vector<double>& misfits) {
  rows.clear();
  misfits.clear();
  double cost = 0;
  for (const PlanarDirection& one : directions) {
    const Vector2d to = one.to - station;
    const double squared = to.squaredNorm();
    rows.push_back(Vector3d(-to.y() / squared, to.x() / squared, -1) / one.sigma_rad);
    misfits.push_back(around_zero(one.direction_rad - azimuth(station, one.to) + orientation) / one.sigma_rad);
    cost += misfits.back() * misfits.back();
  }
  return std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
}

std::optional<Matrix3d> inverse_of(const std::vector<Vector3d>& rows) {
  Matrix3d normal = Matrix3d::Zero();
  for (const Vector3d& row : rows) normal += row * row.transpose();
  const Vector3d scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(scale.asDiagonal() * normal * scale.asDiagonal());
  if (!scale.allFinite() || !(eigen.eigenvalues()[0] > 1e-12)) return std::nullopt;
  const Vector3d values = eigen.eigenvalues().cwiseInverse();
  return Matrix3d(scale.asDiagonal() * eigen.eigenvectors() * values.asDiagonal() * eigen.eigenvectors().transpose() *
                  scale.asDiagonal());
}

std::optional<Vector2d> best_start(std::span<const PlanarDirection> directions) {
  std::optional<Vector2d> best;
  double least = std::numeric_limits<double>::infinity();
  std::vector<Vector3d> rows;
  std::vector<double> misfits;
  int tried = 0;
  for (std::size_t i = 0; i < directions.size(); ++i)
    for (std::size_t j = i + 1; j < directions.size(); ++j)
      for (std::size_t k = j + 1; k < directions.size() && tried < 200; ++k, ++tried) {
        const auto station = of_three(directions[i], directions[j], directions[k]);
        if (!station) continue;
        const double cost = linearise(directions, *station, orientation_at(directions, *station), rows, misfits);
        if (cost < least) {
          least = cost;
          best = station;
        }
      }
  return best;
}

// Misfits over their sigmas.
std::vector<double> misfits_at(std::span<const PlanarDirection> directions, const Vector2d& station,
                               double orientation) {
  std::vector<Vector3d> rows;
  std::vector<double> misfits;
  linearise(directions, station, orientation, rows, misfits);
  return misfits;
}

// By the h-th smallest misfit, in stated ones.
double robust_scale(std::vector<double> misfits) {
  const std::size_t n = misfits.size(), h = median_rank(n, 3) - 1;
  for (double& misfit : misfits) misfit = std::abs(misfit);
  std::nth_element(misfits.begin(), misfits.begin() + static_cast<std::ptrdiff_t>(h), misfits.end());
  return robust_sigma(misfits[h], n, 3, 1);
}

void add_danger_circle(std::span<const PlanarDirection> directions, PlanarResection& out) {
  std::vector<Vector2d> points;
  for (const PlanarDirection& one : directions) points.push_back(one.to);
  const auto circle = danger_circle(points);
  if (!circle) {  // of a line
    out.danger_radius = out.danger_off = std::numeric_limits<double>::infinity();
    return;
  }
  out.danger_radius = circle->radius;
  out.danger_off = (out.station - circle->centre).norm() - circle->radius;
}

}  // namespace

std::optional<DangerCircle> danger_circle(std::span<const Vector2d> points) {
  constexpr double kLine = 1e-12;  // smallest over largest eigenvalue of the scaled equations: extents as 1 to 1e-6
  if (points.size() < 3) return std::nullopt;
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& point : points) middle += point / double(points.size());
  double extent = 0;
  for (const Vector2d& point : points) extent = std::max(extent, (point - middle).norm());
  if (!(extent > 0)) return std::nullopt;
  std::vector<Vector2d> scaled;
  for (const Vector2d& point : points) scaled.push_back((point - middle) / extent);
  const auto circle = algebraic_circle(scaled);
  if (!circle || !(circle->conditioning > kLine)) return std::nullopt;
  DangerCircle out{middle + extent * circle->centre, extent * circle->radius};
  double squares = 0;
  for (const Vector2d& point : points) squares += std::pow((point - out.centre).norm() - out.radius, 2);
  out.points_off = std::sqrt(squares / double(points.size()));
  if (!std::isfinite(out.radius)) return std::nullopt;
  return out;
}

std::optional<OpenArc> open_arc(std::span<const PlanarDirection> directions) {
  constexpr double kExact = 1e-6;  // what planar_resection() takes as on the circle
  std::vector<Vector2d> points;
  for (const PlanarDirection& one : directions) points.push_back(one.to);
  const auto circle = danger_circle(points);
  if (!circle || !(circle->points_off <= kExact * circle->radius)) return std::nullopt;
  std::vector<double> angles;
  for (const Vector2d& point : points)
    angles.push_back(std::atan2(point.y() - circle->centre.y(), point.x() - circle->centre.x()));
  std::sort(angles.begin(), angles.end());
  std::optional<OpenArc> best;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const double from = angles[i], to = i + 1 < angles.size() ? angles[i + 1] : angles[0] + 2 * kPi;
    const double middle = (from + to) / 2;
    const Vector2d station = circle->centre + circle->radius * Vector2d(std::cos(middle), std::sin(middle));
    double squares = 0;
    bool fits = to > from;
    const std::vector<double> misfits = misfits_at(directions, station, orientation_at(directions, station));
    for (std::size_t k = 0; k < misfits.size(); ++k) {
      const double misfit_rad = misfits[k] * directions[k].sigma_rad;
      squares += misfit_rad * misfit_rad;
      fits = fits && (std::abs(misfits[k]) <= 3 || std::abs(misfit_rad) <= kExact);
    }
    const double rms = std::sqrt(squares / double(misfits.size()));
    if (fits && (!best || rms < best->misfit_rad)) best = OpenArc{*circle, from, to, rms};
  }
  return best;
}

std::optional<PlanarResection> planar_resection(std::span<const PlanarDirection> directions) {
  if (directions.size() < 3) return std::nullopt;
  const auto start = best_start(directions);
  if (!start) return std::nullopt;
  PlanarResection out;
  out.station = *start;
  out.orientation_rad = orientation_at(directions, out.station);
  std::vector<Vector3d> rows;
  std::vector<double> misfits;
  double cost = linearise(directions, out.station, out.orientation_rad, rows, misfits);
  std::optional<Matrix3d> inverse;
  for (int iteration = 0; iteration < 50; ++iteration) {
    inverse = inverse_of(rows);
    if (!inverse) return std::nullopt;
    Vector3d right = Vector3d::Zero();
    for (std::size_t i = 0; i < rows.size(); ++i) right += misfits[i] * rows[i];
    Vector3d step = *inverse * right;
    double next = 0;
    for (int halving = 0; halving < 10; ++halving, step /= 2) {
      next = linearise(directions, out.station + step.head<2>(), out.orientation_rad + step.z(), rows, misfits);
      if (next <= cost * (1 + 1e-12) + 1e-20) break;
    }
    out.station += step.head<2>();
    out.orientation_rad += step.z();
    const bool is_settled = cost - next <= 1e-13 * cost;
    cost = next;
    if (is_settled) break;
  }
  if (!std::isfinite(cost)) return std::nullopt;
  inverse = inverse_of(rows);
  if (!inverse) return std::nullopt;
  out.covariance = *inverse;
  out.redundancy = static_cast<int>(directions.size()) - 3;
  if (out.redundancy > 0) out.sigma0 = std::sqrt(cost / out.redundancy);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double redundancy = std::max(0.0, 1 - rows[i].dot(*inverse * rows[i]));
    out.misfits_rad.push_back(misfits[i] * directions[i].sigma_rad);
    out.redundancies.push_back(redundancy);
    out.w.push_back(redundancy > 1e-9 ? misfits[i] / std::sqrt(redundancy) : 0);
  }
  if (out.orientation_rad = std::fmod(out.orientation_rad, 2 * kPi); out.orientation_rad < 0)
    out.orientation_rad += 2 * kPi;
  add_danger_circle(directions, out);
  return out;
}

std::optional<std::vector<std::size_t>> contradicting_directions(std::span<const PlanarDirection> directions,
                                                                 std::uint64_t seed) {
  if (directions.size() < 5) return std::nullopt;
  std::vector<double> best;
  double least = std::numeric_limits<double>::infinity();
  for_triples(directions.size(), 500, seed, [&](std::size_t i, std::size_t j, std::size_t k) {
    const std::array<PlanarDirection, 3> triple{directions[i], directions[j], directions[k]};
    const auto station = of_three(triple[0], triple[1], triple[2]);
    if (!station) return;
    std::vector<double> misfits = misfits_at(directions, *station, orientation_at(triple, *station));
    if (const double scale = robust_scale(misfits); scale < least) {
      least = scale;
      best = std::move(misfits);
    }
  });
  if (best.empty()) return std::nullopt;
  std::vector<std::size_t> wrong;
  for (int round = 0; round < 3; ++round) {
    const double limit = wrong_beyond(1) * std::max(1.0, robust_scale(best));
    std::vector<PlanarDirection> right;
    wrong.clear();
    for (std::size_t i = 0; i < directions.size(); ++i)
      if (std::abs(best[i]) <= limit)
        right.push_back(directions[i]);
      else
        wrong.push_back(i);
    const auto refined = planar_resection(right);
    if (!refined) return std::nullopt;
    best = misfits_at(directions, refined->station, refined->orientation_rad);
  }
  return wrong;
}

}  // namespace collinea
