// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/model_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "collinea/geometry/rotation.h"
#include "collinea/math/fisher.h"
#include "collinea/math/quantiles.h"
#include "collinea/models/internal/local_normals.h"
#include "collinea/models/internal/shared_points.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLeastPivot = 1e-12;      // of the reduced normals, relative to their diagonal
constexpr double kLeastRedundancy = 1e-6;  // below it nothing checks a coordinate
constexpr double kSettled = 1e-10;         // of the weighted squares that a step still takes
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string axis_of(int row) { return row % 3 == 0 ? "X" : row % 3 == 1 ? "Y" : "Z"; }

class Joiner {
 public:
  Joiner(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control, const JoinOptions& options,
         ModelChain chain, const Run& run)
      : models_(models),
        control_(control),
        options_(options),
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

  Result<JoinedBlock> join() {
    JoinedBlock block;
    COLLINEA_TRY(block.steps, settle());
    COLLINEA_TRY(build());
    COLLINEA_TRY(factorise());
    factor_.invert(run_);
    if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
    count(block);
    block.models.resize(models_.size());
    for (std::size_t m = 0; m < models_.size(); ++m)
      if (is_in(m)) COLLINEA_TRY(examine_model(m, block));
    examine_control(block);
    judge(block);
    for (auto& [name, point] : points_) block.points.push_back(std::move(point));
    block.chain = std::move(chain_);
    return block;
  }

 private:
  [[nodiscard]] bool is_in(std::size_t m) const { return chain_.ground_from_model[m].has_value(); }
  [[nodiscard]] bool is_held(std::size_t m) const { return !chain_.on_ground && m == chain_.reference; }
  // Of control that takes part; -1: of other points.
  [[nodiscard]] int number_of(const SurveyedPoint& point) const {
    return point.is_check || !chain_.points.contains(point.name) ? -1 : shared_.number(point.name);
  }

  [[nodiscard]] std::optional<LocalNormals> local(std::size_t m) const {
    std::vector<Vector3d> on_ground;
    for (const NamedPoint& point : models_[m].points) on_ground.push_back(position_.at(point.name));
    return local_normals(models_[m], states_[m], on_ground, shared_.are_shared(m), is_held(m));
  }
  [[nodiscard]] Error no_covariance(std::size_t m) const {
    return {Errc::kIllPosed,
            fmt::format("model {}: its points, or their covariance, do not determine it", models_[m].name)};
  }
  // Rows of the shared points of a model, in the order of its columns.
  [[nodiscard]] std::vector<int> rows_of(std::size_t m) const {
    std::vector<int> rows;
    for (const int number : shared_.numbers(m))
      for (int axis = 0; number >= 0 && axis < 3; ++axis) rows.push_back(3 * number + axis);
    return rows;
  }

  // Reduced normal equations of the shared points.
  Result<> build() {
    matrix_.clear();
    right_.setZero(Index{factor_.tile_rows()} * bundle::kTile);
    squares_ = 0;
    for (std::size_t m = 0; m < models_.size(); ++m) {
      if (!is_in(m)) continue;
      if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
      const auto normals = local(m);
      if (!normals) return tl::unexpected(no_covariance(m));
      squares_ += normals->reduced_obs.dot(normals->weight * normals->reduced_obs);
      add(*normals, rows_of(m));
    }
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
    for (std::size_t row = 0; row < is_fixed_.size(); ++row)
      if (is_fixed_[row]) matrix_.at(static_cast<int>(row), static_cast<int>(row)) = 1;
    return {};
  }

  void add(const LocalNormals& normals, const std::vector<int>& rows) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (is_fixed_[static_cast<std::size_t>(rows[i])]) continue;
      right_[rows[i]] += normals.reduced_right[static_cast<Index>(i)];
      for (std::size_t k = 0; k < rows.size(); ++k)
        if (rows[k] <= rows[i] && !is_fixed_[static_cast<std::size_t>(rows[k])])
          matrix_.at(rows[i], rows[k]) += normals.reduced_matrix(static_cast<Index>(i), static_cast<Index>(k));
    }
  }

  Result<> factorise() {
    if (factor_.factor(matrix_, run_, kLeastPivot)) return {};
    if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
    const int row = factor_.failed_row();
    return fail(Errc::kIllPosed, fmt::format("{} of point {} is not determined by models and control", axis_of(row),
                                             shared_.name(row / 3)));
  }

  // Gauss-Newton, to the end; answers the number of steps.
  Result<int> settle() {
    double least = std::numeric_limits<double>::infinity();
    int worse = 0;
    for (int step = 1; step <= options_.most_steps; ++step) {
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
      if (taken < kSettled * (squares_ + 1)) return step;
    }
    return fail(Errc::kNotConverged, fmt::format("the adjustment has not settled in {} steps: look for a gross error "
                                                 "among models and control",
                                                 options_.most_steps));
  }

  // The model's own unknowns, by those of the shared points. Adds to `taken` the squares that they took.
  Result<> step_model(std::size_t m, const VectorXd& x, double& taken) {
    const auto normals = local(m);
    if (!normals) return tl::unexpected(no_covariance(m));
    const std::vector<int> rows = rows_of(m);
    VectorXd its_x(static_cast<Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) its_x[static_cast<Index>(i)] = x[rows[i]];
    const VectorXd y = normals->start - normals->coupling * its_x;
    taken += normals->start.dot(normals->own.transpose() * (normals->weight * normals->reduced_obs));
    const Index parameters = is_held(m) ? 0 : 7;
    Index next = parameters;
    for (std::size_t i = 0; i < models_[m].points.size(); ++i)
      if (shared_.numbers(m)[i] < 0) {
        own_steps_.emplace_back(models_[m].points[i].name, y.segment<3>(next));
        next += 3;
      }
    if (parameters > 0) states_[m].step(y.head<7>());
    for (const auto& [name, by] : own_steps_) position_.at(name) += by;
    own_steps_.clear();
    return {};
  }

  void count(JoinedBlock& block) const {
    for (std::size_t m = 0; m < models_.size(); ++m) {
      if (!is_in(m)) continue;
      block.observations += 3 * static_cast<long>(models_[m].points.size());
      block.unknowns += is_held(m) ? 0 : 7;
    }
    block.unknowns += 3 * static_cast<long>(chain_.points.size());
    for (const SurveyedPoint& point : control_)
      if (number_of(point) >= 0)
        for (int axis = 0; axis < 3; ++axis) {
          block.unknowns -= point.sigma[axis] == 0 ? 1 : 0;
          block.observations += point.sigma[axis] > 0 && point.has(axis) ? 1 : 0;
        }
    block.squares = squares_;
  }

  // Covariance of shared points of a model.
  [[nodiscard]] MatrixXd covariance_of(const std::vector<int>& rows) {
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

  Result<> examine_model(std::size_t m, JoinedBlock& block) {
    const auto normals = local(m);
    if (!normals) return tl::unexpected(no_covariance(m));
    const LocalNormals& n = *normals;
    const MatrixXd q = covariance_of(rows_of(m));
    const MatrixXd own = n.inverse + n.coupling * q * n.coupling.transpose();
    JoinedModel& out = block.models[m].emplace();
    out.ground_from_model = inverse(states_[m].model_from_ground);
    describe(out, m, own, n.gauge);
    // Adjusted observations: A y + B x = A start + (B - A coupling) x.
    const MatrixXd rest = n.shared - n.own * n.coupling;
    const MatrixXd adjusted = n.own * n.inverse * n.own.transpose() + rest * q * rest.transpose();
    const MatrixXd checked = n.weight - n.weight * adjusted * n.weight;
    const VectorXd weighted = n.weight * n.reduced_obs;
    const VectorXd numbers = VectorXd::Ones(n.weight.rows()) - (adjusted.cwiseProduct(n.weight)).rowwise().sum();
    out.squares = n.reduced_obs.dot(weighted);
    for (std::size_t i = 0; i < models_[m].points.size(); ++i) {
      auto& tests = out.tests.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        const Index row = static_cast<Index>(3 * i) + axis;
        CoordinateTest& test = tests[static_cast<std::size_t>(axis)];
        test.residual = n.reduced_obs[row];
        test.redundancy = numbers[row];
        const double variance = checked(row, row);
        if (variance > kLeastRedundancy * n.weight(row, row)) test.w = weighted[row] / std::sqrt(variance);
      }
    }
    out.redundancy = numbers.sum();
    take_points(m, own, q);
    return {};
  }

  void take_points(std::size_t m, const MatrixXd& own, const MatrixXd& q) {
    Index next_own = is_held(m) ? 0 : 7, next_shared = 0;
    for (std::size_t i = 0; i < models_[m].points.size(); ++i) {
      const bool is_shared = shared_.numbers(m)[i] >= 0;
      Index& next = is_shared ? next_shared : next_own;
      JoinedPoint& point = points_[models_[m].points[i].name];
      point.name = models_[m].points[i].name;
      point.position = position_.at(point.name);
      point.covariance = (is_shared ? q : own).block<3, 3>(next, next);
      ++point.models;
      next += 3;
    }
  }

  // Parameters for people, and their covariance by that of the increments eps, omega, tau.
  void describe(JoinedModel& out, std::size_t m, const MatrixXd& own, const Eigen::Matrix<double, 7, 7>& gauge) const {
    const Similarity3& ground = out.ground_from_model;
    const Matrix3d rotation = ground.rotation.toRotationMatrix();
    // cam_from_world of a camera whose image axes (x right, y up, z backward) are those of the model.
    const OmegaPhiKappa angles = omega_phi_kappa((ground.rotation * Eigen::Quaterniond(0, 1, 0, 0)).conjugate());
    constexpr double kRadian = 3.14159265358979323846 / 180;
    out.omega_rad = angles.omega_deg * kRadian;
    out.phi_rad = angles.phi_deg * kRadian;
    out.kappa_rad = angles.kappa_deg * kRadian;
    if (is_held(m)) return;
    const Vector3d& c = states_[m].centre;
    Eigen::Matrix<double, 7, 7> by = Eigen::Matrix<double, 7, 7>::Zero();
    by.block<3, 1>(0, 0) = ground.scale * (rotation * c);
    by.block<3, 3>(0, 1) = -ground.scale * rotation * skew(c);
    by.block<3, 3>(0, 4) = -ground.scale * rotation;
    by.block<3, 3>(3, 1) = -angles_by_rotation_of_camera(angles) * rotation;
    by(6, 0) = -ground.scale;
    out.covariance = by * (own.topLeftCorner<7, 7>() - gauge) * by.transpose();
  }

  void examine_control(JoinedBlock& block) {
    for (std::size_t k = 0; k < control_.size(); ++k) {
      const SurveyedPoint& given = control_[k];
      JoinedControl& out = block.control.emplace_back();
      out.index = k;
      out.difference.setConstant(kNaN);
      out.sigma.setConstant(kNaN);
      const auto found = points_.find(given.name);
      if (found == points_.end()) continue;
      out.seen = true;
      for (int axis = 0; axis < 3; ++axis) {
        if (!given.has(axis)) continue;
        out.difference[axis] = given.position[axis] - found->second.position[axis];
        const double variance = given.sigma[axis] * given.sigma[axis], left = found->second.covariance(axis, axis);
        if (given.is_check) out.sigma[axis] = std::sqrt(variance + left);
        if (given.is_check || variance == 0) continue;
        CoordinateTest& test = out.tests[static_cast<std::size_t>(axis)];
        test.residual = out.difference[axis];
        test.redundancy = 1 - left / variance;
        if (test.redundancy > kLeastRedundancy) test.w = test.residual / std::sqrt(variance - left);
      }
    }
  }

  // Test of the whole, and what follows where the sigmas are known up to a factor alone.
  void judge(JoinedBlock& block) {
    const auto redundancy = static_cast<double>(block.redundancy());
    block.sigma0 = redundancy > 0 ? std::sqrt(block.squares / redundancy) : kNaN;
    block.limit = normal_limit(options_.false_alarm);
    if (redundancy > 0)
      block.chance = fisher_tail(block.squares / redundancy, redundancy, std::numeric_limits<double>::infinity());
    if (options_.sigmas_known || !(redundancy > 0) || !(block.sigma0 > 0)) return;
    block.variance_factor = block.sigma0 * block.sigma0;
    block.limit = tau_limit(options_.false_alarm, block.redundancy());
    for (auto& [name, point] : points_) point.covariance *= block.variance_factor;
    const auto scale_tests = [&](std::array<CoordinateTest, 3>& tests) {
      for (CoordinateTest& test : tests) test.w /= block.sigma0;
    };
    for (auto& model : block.models) {
      if (!model) continue;
      model->covariance *= block.variance_factor;
      for (auto& tests : model->tests) scale_tests(tests);
    }
    for (JoinedControl& one : block.control) {
      scale_tests(one.tests);
      one.sigma *= block.sigma0;
    }
  }

  const std::vector<StereoModel>& models_;
  const std::vector<SurveyedPoint>& control_;
  const JoinOptions& options_;
  const Run& run_;
  ModelChain chain_;
  SharedPoints shared_;
  std::vector<ModelState> states_;
  std::map<std::string, Vector3d> position_;
  std::vector<bool> is_fixed_;  // of each row
  bundle::TileMatrix matrix_;
  bundle::TileCholesky factor_;
  VectorXd right_;
  double squares_ = 0;
  std::map<std::string, JoinedPoint> points_;
  std::vector<std::pair<std::string, Vector3d>> own_steps_;
};

}  // namespace

Result<JoinedBlock> join_models(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
                                const JoinOptions& options, const Run& run) {
  // Near the origin, for digits.
  Vector3d origin = Vector3d::Zero(), count = Vector3d::Zero();
  for (const SurveyedPoint& point : control)
    for (int axis = 0; axis < 3; ++axis)
      if (point.has(axis)) {
        if (!std::isfinite(point.position[axis]) || !(point.sigma[axis] >= 0))
          return fail(Errc::kBadInput,
                      fmt::format("control point {}: a coordinate or its standard deviation is no number", point.name));
        origin[axis] += point.position[axis];
        ++count[axis];
      }
  origin = origin.cwiseQuotient(count.cwiseMax(1));
  std::vector<SurveyedPoint> near = control;
  for (SurveyedPoint& point : near) point.position -= origin;
  COLLINEA_TRY(ModelChain chain, chain_models(models, near));
  COLLINEA_TRY(JoinedBlock block, Joiner(models, near, options, std::move(chain), run).join());
  for (JoinedPoint& point : block.points) point.position += origin;
  for (auto& model : block.models)
    if (model) model->ground_from_model.translation += origin;
  for (auto& start : block.chain.ground_from_model)
    if (start) start->translation += origin;
  for (auto& [name, position] : block.chain.points) position += origin;
  return block;
}

}  // namespace collinea
