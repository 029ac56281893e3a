// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/internal/block_normals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLeastPivot = 1e-12;  // of the reduced normals, relative to their diagonal
constexpr double kSettled = 1e-10;     // of the weighted squares that a step still takes

std::string axis_of(int row) { return row % 3 == 0 ? "X" : row % 3 == 1 ? "Y" : "Z"; }

}  // namespace

BlockNormals::BlockNormals(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
                           ModelChain chain, const Run& run)
    : models_(models),
      control_(control),
      run_(run),
      chain_(std::move(chain)),
      shared_(models, control, chain_),
      states_(models.size()),
      is_fixed_(static_cast<std::size_t>(3 * shared_.count()), false),
      matrix_(3 * shared_.count(), shared_.pattern()),
      factor_(3 * shared_.count(), shared_.pattern()) {
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (!is_in(m)) continue;
    Vector3d centre = Vector3d::Zero();
    for (const NamedPoint& point : models[m].points) centre += point.position / double(models[m].points.size());
    states_[m] = {inverse(*chain_.ground_from_model[m]), centre};
  }
  position_ = chain_.points;
  for (const SurveyedPoint& point : control_)
    if (const int number = number_of(point); number >= 0)
      for (int axis = 0; axis < 3; ++axis)
        if (point.sigma[axis] == 0) {
          is_fixed_[static_cast<std::size_t>(3 * number + axis)] = true;
          position_.at(point.name)[axis] = point.position[axis];
        }
}

Result<LocalNormals> BlockNormals::local(std::size_t m) const {
  std::vector<Vector3d> on_ground;
  for (const NamedPoint& point : models_[m].points) on_ground.push_back(position_.at(point.name));
  auto normals = local_normals(models_[m], states_[m], on_ground, shared_.are_shared(m), is_held(m));
  if (normals) return *std::move(normals);
  return fail(Errc::kIllPosed,
              fmt::format("model {}: its points, or their covariance, do not determine it", models_[m].name));
}

// Rows of the shared points of a model, in the order of its columns.
std::vector<int> BlockNormals::rows_of(std::size_t m) const {
  std::vector<int> rows;
  for (const int number : shared_.numbers(m))
    for (int axis = 0; number >= 0 && axis < 3; ++axis) rows.push_back(3 * number + axis);
  return rows;
}

// Reduced normal equations of the shared points.
Result<> BlockNormals::build() {
  matrix_.clear();
  right_.setZero(Index{factor_.tile_rows()} * bundle::kTile);
  squares_ = 0;
  for (std::size_t m = 0; m < models_.size(); ++m) {
    if (!is_in(m)) continue;
    if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
    const auto normals = local(m);
    if (!normals) return tl::unexpected(normals.error());
    squares_ += normals->reduced_obs.dot(normals->weight * normals->reduced_obs);
    add(*normals, rows_of(m));
  }
  add_control();
  for (std::size_t row = 0; row < is_fixed_.size(); ++row)
    if (is_fixed_[row]) matrix_.at(static_cast<int>(row), static_cast<int>(row)) = 1;
  return {};
}

void BlockNormals::add(const LocalNormals& normals, const std::vector<int>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (is_fixed_[static_cast<std::size_t>(rows[i])]) continue;
    right_[rows[i]] += normals.reduced_right[static_cast<Index>(i)];
    for (std::size_t k = 0; k < rows.size(); ++k)
      if (rows[k] <= rows[i] && !is_fixed_[static_cast<std::size_t>(rows[k])])
        matrix_.at(rows[i], rows[k]) += normals.reduced_matrix(static_cast<Index>(i), static_cast<Index>(k));
  }
}

Result<> BlockNormals::factorise() {
  if (factor_.factor(matrix_, run_, kLeastPivot)) return {};
  if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
  const int row = factor_.failed_row();
  return fail(Errc::kIllPosed, fmt::format("{} of point {} is not determined by models and control", axis_of(row),
                                           shared_.name(row / 3)));
}

// Gauss-Newton, to the end; answers the number of steps.
Result<int> BlockNormals::settle(int most_steps) {
  double least = std::numeric_limits<double>::infinity();
  int worse = 0;
  for (int step = 1; step <= most_steps; ++step) {
    COLLINEA_TRY(build());
    if (!std::isfinite(squares_) || (worse += squares_ > 1.5 * least) > 3)
      return fail(Errc::kNotConverged, "the adjustment diverges: look for a gross error among models and control");
    least = std::min(least, squares_);
    COLLINEA_TRY(factorise());
    VectorXd x = right_;
    factor_.solve(x.data());
    double taken = right_.dot(x);
    for (std::size_t m = 0; m < models_.size(); ++m)
      if (is_in(m)) COLLINEA_TRY(step_model(m, x, taken));
    for (int number = 0; number < shared_.count(); ++number)
      position_.at(shared_.name(number)) += x.segment<3>(3 * number);
    if (taken > kSettled * (squares_ + 1)) continue;
    COLLINEA_TRY(build());
    COLLINEA_TRY(factorise());
    factor_.invert(run_);
    if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
    return step;
  }
  return fail(Errc::kNotConverged, fmt::format("the adjustment has not settled in {} steps: look for a gross error "
                                               "among models and control",
                                               most_steps));
}

// The model's own unknowns, by those of the shared points. Adds to `taken` the squares that they took.
Result<> BlockNormals::step_model(std::size_t m, const VectorXd& x, double& taken) {
  const auto normals = local(m);
  if (!normals) return tl::unexpected(normals.error());
  const std::vector<int> rows = rows_of(m);
  VectorXd its_x(static_cast<Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) its_x[static_cast<Index>(i)] = x[rows[i]];
  const VectorXd y = normals->start - normals->coupling * its_x;
  taken += normals->start.dot(normals->own.transpose() * (normals->weight * normals->reduced_obs));
  const Index parameters = is_held(m) ? 0 : 7;
  Index next = parameters;
  for (std::size_t i = 0; i < models_[m].points.size(); ++i)
    if (shared_.numbers(m)[i] < 0) {
      position_.at(models_[m].points[i].name) += y.segment<3>(next);
      next += 3;
    }
  if (parameters > 0) states_[m].step(y.head<7>());
  return {};
}

void BlockNormals::add_control() {
  for (const SurveyedPoint& point : control_)
    if (const int number = number_of(point); number >= 0)
      for (int axis = 0; axis < 3; ++axis) {
        if (point.sigma[axis] == 0 || !point.has(axis)) continue;
        const double weight = 1 / (point.sigma[axis] * point.sigma[axis]);
        const double l = point.position[axis] - position_.at(point.name)[axis];
        matrix_.at(3 * number + axis, 3 * number + axis) += weight;
        right_[3 * number + axis] += weight * l;
        squares_ += weight * l * l;
      }
}

MatrixXd BlockNormals::covariance_of(std::size_t m) {
  const std::vector<int> rows = rows_of(m);
  const auto n = static_cast<Index>(rows.size());
  MatrixXd q = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i)
    for (Index k = 0; k < n; ++k) {
      const int a = rows[static_cast<std::size_t>(i)], b = rows[static_cast<std::size_t>(k)];
      if (!is_fixed_[static_cast<std::size_t>(a)] && !is_fixed_[static_cast<std::size_t>(b)])
        q(i, k) = factor_.at(std::max(a, b), std::min(a, b));
    }
  return q;
}

}  // namespace collinea
