// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/relative_orientation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "collinea/epipolar/relative_start.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/median.h"
#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

constexpr std::size_t kUnknowns = 5;
constexpr std::size_t kRobustPoints = 8;
constexpr int kMostIterations = 60;
constexpr double kLongestStep_rad = 0.3;
constexpr double kSettled_rad = 1e-11, kSettledOfSigma = 1e-5;
constexpr double kUndetermined = 1e-12;  // lambda_min / lambda_max of the scaled normal matrix

// One point in an adjustment.
struct Equation {
  Eigen::Vector4d v = Eigen::Vector4d::Zero();  // residuals so far
  Eigen::Vector4d by_coordinates;
  Vector5 by_change;
  double misclosure = 0;  // w = C(l + v) - B v
  double variance = 0;    // M = B Q B'
  double weight = 1;      // by distribution
  bool used = true;
};

struct Adjustment {
  Rigid3 motion;
  std::vector<Equation> equations;
  Matrix5 normal, inverse, covariance;
  int iterations = 0;
  bool settled = false;
};

Eigen::Vector4d variances_of(const PairPoint& point) {
  const double one = point.sigma_first * point.sigma_first, two = point.sigma_second * point.sigma_second;
  return {one, one, two, two};
}

// What the rotation and the base are, while all points ask for them.
struct Linearised {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d base;
  Eigen::Matrix<double, 3, 2> tangents;

  explicit Linearised(const Rigid3& motion)
      : rotation(motion.rotation.toRotationMatrix()), base(base_in_first(motion)), tangents(tangents_of(base)) {}

  // C, A, B at the adjusted coordinates.
  void at(const PairPoint& point, Equation& equation) const {
    const Eigen::Vector3d first = (point.first + equation.v.head<2>()).homogeneous(),
                          second = (point.second + equation.v.tail<2>()).homogeneous();
    const Eigen::Vector3d turned = rotation.transpose() * second, normal = first.cross(turned);
    const Eigen::Vector3d across = rotation * base.cross(first);
    equation.by_change.head<3>() = across.cross(second);
    equation.by_change.tail<2>() = tangents.transpose() * normal;
    const Eigen::Vector3d by_first = turned.cross(base);
    equation.by_coordinates << by_first.x(), by_first.y(), across.x(), across.y();
    equation.misclosure = base.dot(normal) - equation.by_coordinates.dot(equation.v);
    const Eigen::Vector4d b2 = equation.by_coordinates.cwiseAbs2();
    equation.variance = (b2(0) + b2(1)) * point.sigma_first * point.sigma_first +
                        (b2(2) + b2(3)) * point.sigma_second * point.sigma_second;
  }
};

// Normal equations of the used points; false where they are singular.
bool step_of(std::span<const PairPoint> points, Adjustment& work, Vector5& step) {
  const Linearised at(work.motion);
  work.normal.setZero();
  Vector5 right = Vector5::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    Equation& equation = work.equations[i];
    if (!equation.used) continue;
    at.at(points[i], equation);
    if (!(equation.variance > 0)) continue;
    const Vector5 weighted = equation.by_change * (equation.weight / equation.variance);
    work.normal.noalias() += weighted * equation.by_change.transpose();
    right.noalias() -= weighted * equation.misclosure;
  }
  const Vector5 scale = work.normal.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Matrix5 scaled = scale.asDiagonal() * work.normal * scale.asDiagonal();
  const Eigen::LDLT<Matrix5> solver(scaled);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > kUndetermined)) return false;
  step = scale.asDiagonal() * solver.solve(scale.asDiagonal() * right);
  work.inverse = scale.asDiagonal() * solver.solve(Matrix5::Identity()) * scale.asDiagonal();
  return step.allFinite();
}

// v = -Q B' M^-1 (w + A dx)
void set_residuals(std::span<const PairPoint> points, const Vector5& step, Adjustment& work) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    Equation& equation = work.equations[i];
    if (!equation.used || !(equation.variance > 0)) continue;
    const double left = equation.misclosure + equation.by_change.dot(step);
    equation.v = -variances_of(points[i]).cwiseProduct(equation.by_coordinates) * (left / equation.variance);
  }
}

// Iterates from work.motion; false where the normal equations are singular.
bool adjust(std::span<const PairPoint> points, Adjustment& work) {
  work.settled = false;
  for (work.iterations = 1; work.iterations <= kMostIterations; ++work.iterations) {
    Vector5 step;
    if (!step_of(points, work, step)) return false;
    const double length = step.norm(), of_sigma = step.dot(work.normal * step);
    if (length > kLongestStep_rad) step *= kLongestStep_rad / length;
    set_residuals(points, step, work);
    work.motion = changed(work.motion, step);
    if (length < kSettled_rad || (length < 1e-6 && of_sigma < kSettledOfSigma * kSettledOfSigma)) {
      work.settled = true;
      break;
    }
  }
  return true;
}

// N^-1 (A' W M W A) N^-1: weights by distribution are not those of the measurements.
void set_covariance(Adjustment& work) {
  Matrix5 middle = Matrix5::Zero();
  for (const Equation& equation : work.equations)
    if (equation.used && equation.variance > 0)
      middle +=
          equation.by_change * equation.by_change.transpose() * (equation.weight * equation.weight / equation.variance);
  work.covariance = work.inverse * middle * work.inverse;
}

double longest(const PairPoint& point, const Eigen::Vector4d& v) {
  return std::max(v.head<2>().norm() / point.sigma_first, v.tail<2>().norm() / point.sigma_second);
}

// Residuals of all points and what follows from those used: sigma0, redundancy.
void set_statistics(std::span<const PairPoint> points, const Adjustment& work, RelativeOrientation& out) {
  const Linearised at(work.motion);
  out.residuals.assign(points.size(), {});
  double squares = 0;
  out.redundancy = 0;
  out.used = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Equation equation = work.equations[i];
    PairResidual& residual = out.residuals[i];
    residual.used = equation.used;
    if (!equation.used) equation.v.setZero();
    at.at(points[i], equation);
    if (!(equation.variance > 0)) continue;
    const double own = equation.by_change.dot(work.covariance * equation.by_change),
                 cross = equation.by_change.dot(work.inverse * equation.by_change);
    // Variance of the misclosure after the adjustment: of its own measurement, less what it gave to the orientation.
    const double variance =
        equation.used ? equation.variance - 2 * equation.weight * cross + own : equation.variance + own;
    const Eigen::Vector4d v =
        -variances_of(points[i]).cwiseProduct(equation.by_coordinates) * (equation.misclosure / equation.variance);
    residual.first = v.head<2>();
    residual.second = v.tail<2>();
    residual.y_parallax = std::copysign(v.head<2>().norm() + v.tail<2>().norm(),
                                        at.base.x() < 0 ? -equation.misclosure : equation.misclosure);
    residual.redundancy = equation.used ? std::clamp(variance / equation.variance, 0.0, 1.0) : 1;
    residual.largest = longest(points[i], v);
    const double least = 1e-9 * equation.variance;
    residual.standardised = variance > least ? equation.misclosure / std::sqrt(variance) : 0;
    if (!equation.used) continue;
    ++out.used;
    out.redundancy += variance / equation.variance;
    squares += equation.misclosure * equation.misclosure / equation.variance;
  }
  if (out.redundancy < 0.5) out.redundancy = 0;
  out.sigma0 = out.redundancy > 0 ? std::sqrt(squares / out.redundancy) : 0;
}

// Of many points tau follows from Student's t, whose limit takes microseconds; tau_limit() sums a term for each degree
// of freedom, milliseconds for a thousand of them.
double critical_value(const RelativeOptions& options, double redundancy) {
  constexpr double kMany = 50;
  if (options.sigma_known) return normal_limit(options.alpha);
  if (redundancy < kMany) return tau_limit(options.alpha, std::lround(redundancy));
  const double t = student_limit(options.alpha, redundancy - 1);
  return std::sqrt(redundancy) * t / std::sqrt(redundancy - 1 + t * t);
}

// How far beyond its limit a point is: above 1 it is to be rejected.
double excess(const PairResidual& residual, const RelativeOptions& options, const RelativeOrientation& state) {
  const double unit = options.sigma_known ? 1 : state.sigma0;
  if (!(unit > 0)) return 0;
  if (options.rejection == PairRejection::kResidual) return residual.largest / (options.residual_limit * unit);
  return std::abs(residual.standardised) / (state.limit * unit);
}

std::optional<std::size_t> worst(const RelativeOptions& options, const RelativeOrientation& state) {
  std::optional<std::size_t> found;
  double most = 1;
  for (std::size_t i = 0; i < state.residuals.size(); ++i)
    if (const PairResidual& r = state.residuals[i]; r.used && excess(r, options, state) > most) {
      most = excess(r, options, state);
      found = i;
    }
  return found;
}

tl::unexpected<Error> undetermined(const Rigid3& motion, std::span<const PairPoint> points) {
  const auto shape = pair_shape(motion, points, normal_of(motion, points));
  if (!shape || shape->weaknesses.empty())
    return fail(Errc::kIllPosed, "the points leave the relative orientation undetermined; measure more, elsewhere");
  std::string_view why;
  for (const auto& entry : words(PairWeakness{}))
    if (entry.value == shape->weaknesses.front()) why = entry.meaning;
  return fail(Errc::kIllPosed, "the points leave the relative orientation undetermined: " + std::string(why) +
                                   "; measure points that lie elsewhere");
}

// A motion to begin with, and the points that it was made of.
struct Start {
  Rigid3 motion;
  std::vector<int> inliers = {};  // empty: all
  std::optional<RelativeSearch> search = {};
};

std::optional<Start> robust(std::span<const PairPoint> points, std::uint64_t seed) {
  std::vector<double> sigmas_first, sigmas_second;
  PointPairs pairs;
  pairs.reserve(points.size());
  for (const PairPoint& point : points) {
    pairs.add(point.first, point.second);
    sigmas_first.push_back(point.sigma_first);
    sigmas_second.push_back(point.sigma_second);
  }
  pairs.focal_first_px = 1 / median(std::move(sigmas_first));  // a "pixel" is a sigma
  pairs.focal_second_px = 1 / median(std::move(sigmas_second));
  const auto start = relative_start(pairs, RobustStart::kLeastMedian, seed);
  if (!start) return std::nullopt;
  return Start{start->second_from_first, start->inliers};
}

std::optional<Start> searched(std::span<const PairPoint> points) {
  auto search = search_relative(points);
  if (!search) return std::nullopt;
  const Rigid3* best = nullptr;
  int most = -1;
  for (const Rigid3& motion : search->distinct)
    if (const int count = relative_solutions(motion, points)[0].in_front; count > most) {
      most = count;
      best = &motion;
    }
  return Start{*best, {}, std::move(search)};
}

std::optional<Start> start_of(std::span<const PairPoint> points, PairStart kind, std::uint64_t seed) {
  switch (kind) {
    case PairStart::kNearVertical:
      return Start{motion_of(DependentElements{})};
    case PairStart::kLinear:
      if (const auto elements = linear_parallax(points)) return Start{motion_of(*elements)};
      return std::nullopt;
    case PairStart::kRobust:
      if (points.size() >= kRobustPoints) return robust(points, seed);
      [[fallthrough]];
    case PairStart::kGrid:
      return searched(points);
  }
  return std::nullopt;
}

// Points that the start left out, though they fit, take part again.
bool readmit(const RelativeOptions& options, Adjustment& work, const RelativeOrientation& state) {
  bool any = false;
  for (std::size_t i = 0; i < work.equations.size(); ++i)
    if (Equation& equation = work.equations[i]; !equation.used && excess(state.residuals[i], options, state) <= 1) {
      equation.used = true;
      equation.v.setZero();
      any = true;
    }
  return any;
}

Result<> check(std::span<const PairPoint> points) {
  if (points.size() < kUnknowns)
    return fail(Errc::kIllPosed,
                "a relative orientation needs five points in both images, and redundancy six and more; "
                "there are " +
                    std::to_string(points.size()));
  for (const PairPoint& point : points)
    if (!(point.sigma_first > 0 && point.sigma_second > 0 && std::isfinite(point.sigma_first) &&
          std::isfinite(point.sigma_second) && point.first.allFinite() && point.second.allFinite()))
      return fail(Errc::kBadInput, "image coordinates must be numbers and their standard deviations positive");
  return {};
}

// Adjusts and sets the statistics.
Result<> solve(std::span<const PairPoint> points, const RelativeOptions& options, Adjustment& work,
               RelativeOrientation& state) {
  if (!adjust(points, work)) return undetermined(work.motion, points);
  if (!work.settled) {
    const auto shape = pair_shape(work.motion, points, work.normal);
    if (shape && shape->epsilon < 1e-6) return undetermined(work.motion, points);
    return fail(Errc::kNotConverged,
                "the relative orientation does not converge: the start is too far off, or many points are wrong",
                {"start"_option});
  }
  set_covariance(work);
  set_statistics(points, work, state);
  state.limit = critical_value(options, std::max(1.0, state.redundancy));
  return {};
}

}  // namespace

Result<RelativeOrientation> relative_orientation(std::span<const PairPoint> points, const RelativeOptions& options,
                                                 std::uint64_t seed, const std::optional<Rigid3>& given) {
  COLLINEA_TRY(check(points));
  const auto start = given ? std::optional(Start{*given}) : start_of(points, options.start, seed);
  if (!start)
    return fail(Errc::kIllPosed, "no approximate values of the relative orientation: the points do not determine it",
                {"start"_option});
  Adjustment work;
  work.motion = start->motion;
  work.equations.resize(points.size());
  const std::vector<double> weights = distribution_weights(points, options.weights);
  for (std::size_t i = 0; i < points.size(); ++i) work.equations[i].weight = weights[i];
  const bool rejects = options.rejection != PairRejection::kNone;
  if (rejects && start->inliers.size() > kUnknowns) {
    for (Equation& equation : work.equations) equation.used = false;
    for (const int i : start->inliers) work.equations[static_cast<std::size_t>(i)].used = true;
  }

  RelativeOrientation out;
  COLLINEA_TRY(solve(points, options, work, out));
  if (rejects && readmit(options, work, out)) COLLINEA_TRY(solve(points, options, work, out));
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!work.equations[i].used) out.rejected.push_back(static_cast<int>(i));
  while (rejects && out.redundancy > 1.5) {
    const auto found = worst(options, out);
    if (!found) break;
    work.equations[*found].used = false;
    out.rejected.push_back(static_cast<int>(*found));
    COLLINEA_TRY(solve(points, options, work, out));
  }

  std::vector<PairPoint> used;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (work.equations[i].used) used.push_back(points[i]);
  const RelativeSolution choice = relative_solutions(work.motion, used)[0];
  if (angle_between(choice.second_from_first.rotation, work.motion.rotation) > 1e-6 ||
      base_in_first(choice.second_from_first).dot(base_in_first(work.motion)) < 0) {
    work.motion = choice.second_from_first;  // the same condition in other unknowns
    COLLINEA_TRY(solve(points, options, work, out));
  }
  out.second_from_first = work.motion;
  out.search = start->search;
  out.in_front = choice.in_front;
  out.iterations = work.iterations;
  out.covariance = work.covariance;
  out.normal = normal_of(work.motion, used);
  out.variance_factor = options.sigma_known || out.redundancy == 0 ? 1 : out.sigma0 * out.sigma0;
  return out;
}

Result<RelativeOrientation> given_orientation(std::span<const PairPoint> points, const Rigid3& second_from_first,
                                              const Matrix5& covariance, const RelativeOptions& options) {
  COLLINEA_TRY(check(points));
  Adjustment work;
  work.motion = second_from_first;
  work.motion.translation.normalize();
  work.equations.resize(points.size());
  work.normal = work.inverse = work.covariance = Matrix5::Zero();  // the points gave nothing to the orientation
  RelativeOrientation out;
  const auto state = [&] {
    set_statistics(points, work, out);
    out.limit = critical_value(options, std::max(1.0, out.redundancy));
  };
  state();
  while (options.rejection != PairRejection::kNone && out.redundancy > 1.5) {
    const auto found = worst(options, out);
    if (!found) break;
    work.equations[*found].used = false;
    out.rejected.push_back(static_cast<int>(*found));
    state();
  }
  std::vector<PairPoint> used;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (work.equations[i].used) used.push_back(points[i]);
  for (const RelativeSolution& one : relative_solutions(work.motion, used))
    if (angle_between(one.second_from_first.rotation, work.motion.rotation) < 1e-6 &&
        base_in_first(one.second_from_first).dot(base_in_first(work.motion)) > 0)
      out.in_front = one.in_front;
  out.second_from_first = work.motion;
  out.normal = normal_of(work.motion, used);
  out.variance_factor = options.sigma_known || !(out.sigma0 > 0) ? 1 : out.sigma0 * out.sigma0;
  out.covariance = covariance / out.variance_factor;
  return out;
}

std::optional<CriticalPair> critical_pair(std::span<const PairPoint> points, const RelativeOptions& options,
                                          std::uint64_t seed) {
  if (!check(points)) return std::nullopt;
  const auto start = start_of(points, options.start, seed);
  Adjustment work;
  work.motion = start ? start->motion : motion_of(DependentElements{});
  work.equations.resize(points.size());
  (void)adjust(points, work);  // as far as it goes
  const auto shape = pair_shape(work.motion, points, normal_of(work.motion, points));
  if (!shape) return std::nullopt;
  return CriticalPair{work.motion, *shape};
}

}  // namespace collinea
