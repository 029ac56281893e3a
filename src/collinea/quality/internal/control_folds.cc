// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/control_folds.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "collinea/base/parallel.h"
#include "collinea/quality/internal/point_cofactor.h"

namespace collinea {

LeftOutRms rms_of(const std::vector<LeftOutPoint>& points, bool height) {
  LeftOutRms rms;
  for (const LeftOutPoint& one : points) {
    const double square = height ? std::pow(one.difference_m.z(), 2) : one.difference_m.head<2>().squaredNorm();
    if (!std::isfinite(square)) continue;
    ++rms.points;
    rms.difference_m += square;
    rms.predicted_m +=
        height ? std::pow(one.difference_sigma_m.z(), 2) : one.difference_sigma_m.head<2>().squaredNorm();
  }
  if (rms.points == 0) return rms;
  rms.difference_m = std::sqrt(rms.difference_m / rms.points);
  rms.predicted_m = std::sqrt(rms.predicted_m / rms.points);
  return rms;
}

namespace bundle {
namespace {

constexpr std::size_t kMostPoints = 500;
constexpr double kNotDetermined = 1e-6;  // as for single points
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Eigen::Vector3d position_of(const State& state, std::size_t point) {
  return Eigen::Map<const Eigen::Vector3d>(&state.points[3 * point]);
}

}  // namespace

ControlFolds::ControlFolds(const Solved& solved, const TileCholesky& factor, const Run& run) {
  const Problem& problem = solved.problem();
  const State& state = solved.state();
  for (std::size_t p = problem.first_control; p < problem.point_count(); ++p)
    if (const ProblemPoint& point = problem.point(p);
        point.control >= 0 && !point.is_fixed &&
        *std::max_element(problem.control[point.control].inverse_sigma,
                          problem.control[point.control].inverse_sigma + 3) > 0)
      points_.push_back(p);
  if (points_.size() > kMostPoints) points_.clear();
  std::vector<PointSystem> systems;
  for (const std::size_t p : points_) systems.emplace_back(problem, state, p);
  cofactor_.resize(static_cast<Eigen::Index>(3 * points_.size()), static_cast<Eigen::Index>(3 * points_.size()));
  const int globals_begin = 6 * problem.poses;
  parallel_for(run, 3 * points_.size(), [&](std::size_t column) {
    const std::size_t i = column / 3;
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(column % 3));
    Eigen::VectorXd x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(factor.tile_rows()) * kTile);
    if (const int first_retained = problem.point(points_[i]).first_retained; first_retained >= 0)
      x.segment<3>(globals_begin + first_retained) = axis;
    else
      systems[i].add_following(axis, x);
    factor.solve(x.data());
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const int first_retained = problem.point(points_[k]).first_retained;
      Eigen::Vector3d with = first_retained >= 0 ? Eigen::Vector3d(x.segment<3>(globals_begin + first_retained))
                                                 : systems[k].follow(x.data());
      if (k == i && first_retained < 0) with += systems[i].solve_own(axis);
      cofactor_.block<3, 1>(static_cast<Eigen::Index>(3 * k), static_cast<Eigen::Index>(column)) = with;
    }
  });
}

// Each as far as possible from those before, the first from their middle: in turns they make parts that are spread.
std::vector<std::size_t> ControlFolds::spread(const State& state) const {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const std::size_t p : points_) middle += position_of(state, p) / static_cast<double>(points_.size());
  std::vector<double> distance;
  for (const std::size_t p : points_) distance.push_back((position_of(state, p) - middle).norm());
  std::vector<std::size_t> order;
  std::vector<bool> taken(points_.size(), false);
  while (order.size() < points_.size()) {
    std::size_t farthest = points_.size();
    for (std::size_t i = 0; i < points_.size(); ++i)
      if (!taken[i] && (farthest == points_.size() || distance[i] > distance[farthest])) farthest = i;
    taken[farthest] = true;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const double to = (position_of(state, points_[i]) - position_of(state, points_[farthest])).norm();
      distance[i] = order.empty() ? to : std::min(distance[i], to);
    }
    order.push_back(farthest);
  }
  return order;
}

std::vector<LeftOutPoint> without_coordinates(const std::vector<ControlId>& points, const Eigen::MatrixXd& cofactor,
                                              const Eigen::VectorXd& differences, const Eigen::MatrixXd& weights,
                                              const Eigen::VectorXd& survey, double variance) {
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(Eigen::MatrixXd::Identity(cofactor.rows(), cofactor.cols()) -
                                             cofactor * weights);
  if (lu.matrixLU().diagonal().cwiseAbs().minCoeff() < kNotDetermined) return {};
  const Eigen::VectorXd known = (weights.diagonal().array() > 0).select(differences, 0), moved = lu.solve(known);
  const Eigen::MatrixXd without = lu.solve(cofactor);
  std::vector<LeftOutPoint> left_out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    LeftOutPoint point{points[i], Eigen::Vector3d::Constant(kNaN), Eigen::Vector3d::Constant(kNaN)};
    for (int axis = 0; axis < 3; ++axis) {
      const auto row = static_cast<Eigen::Index>(3 * i) + axis;
      if (!(weights(row, row) > 0)) continue;
      point.difference_m[axis] = moved[row];
      point.difference_sigma_m[axis] = std::sqrt(std::max(variance * without(row, row) + survey[row], 0.0));
    }
    left_out.push_back(point);
  }
  return left_out;
}

Folded ControlFolds::leave_out(const Solved& solved, const Adjusted& adjusted, int folds) const {
  const Problem& problem = solved.problem();
  const State& state = solved.state();
  Folded out;
  out.folds = std::min(folds, static_cast<int>(points_.size() / 2));
  if (out.folds < 2) {
    out.folds = 0;
    return out;
  }
  const std::vector<std::size_t> order = spread(state);
  std::map<ControlId, std::pair<int, LeftOutPoint>> found;
  const double variance = std::pow(sigma_scale(adjusted), 2);
  for (int fold = 0; fold < out.folds; ++fold) {
    std::vector<std::size_t> members;
    for (auto i = static_cast<std::size_t>(fold); i < order.size(); i += static_cast<std::size_t>(out.folds))
      members.push_back(order[i]);
    const auto size = static_cast<Eigen::Index>(3 * members.size());
    Eigen::MatrixXd q(size, size), weights = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd difference(size), survey(size);  // survey: variances of the given coordinates
    for (std::size_t a = 0; a < members.size(); ++a) {
      const std::size_t p = points_[members[a]];
      const ControlCoordinates& given = problem.control[problem.point(p).control];
      const auto first = static_cast<Eigen::Index>(3 * a);
      weights.block<3, 3>(first, first) = given.weight();
      survey.segment<3>(first) = inverse_weight(given).diagonal();
      for (int axis = 0; axis < 3; ++axis) difference[first + axis] = position_of(state, p)[axis] - given.given[axis];
      for (std::size_t b = 0; b < members.size(); ++b)
        q.block<3, 3>(static_cast<Eigen::Index>(3 * a), static_cast<Eigen::Index>(3 * b)) =
            cofactor_.block<3, 3>(static_cast<Eigen::Index>(3 * members[a]), static_cast<Eigen::Index>(3 * members[b]));
    }
    std::vector<ControlId> ids;
    for (const std::size_t member : members) ids.push_back(ControlId{problem.point(points_[member]).id});
    for (const LeftOutPoint& point : without_coordinates(ids, q, difference, weights, survey, variance))
      found[point.point] = {fold + 1, point};
  }
  for (const auto& [id, one] : found) {
    out.part.push_back(one.first);
    out.points.push_back(one.second);
  }
  return out;
}

}  // namespace bundle
}  // namespace collinea
