// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/model_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "collinea/geometry/rotation.h"
#include "collinea/math/fisher.h"
#include "collinea/math/quantiles.h"
#include "collinea/models/internal/better_start.h"
#include "collinea/models/internal/block_normals.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLeastChecked = 0.005;    // the same of a test in a model: exact coordinates of its frame have none
constexpr double kLeastRedundancy = 1e-6;  // below it nothing checks a coordinate
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// What follows from the solution of a block: covariances and tests.
class Examination {
 public:
  Examination(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
              const JoinOptions& options, BlockNormals& normals)
      : models_(models), control_(control), options_(options), normals_(normals) {}

  Result<JoinedBlock> examine() {
    JoinedBlock block;
    count(block);
    block.models.resize(models_.size());
    for (std::size_t m = 0; m < models_.size(); ++m)
      if (normals_.is_in(m)) COLLINEA_TRY(examine_model(m, block));
    examine_control(block);
    judge(block);
    for (auto& [name, point] : points_) block.points.push_back(std::move(point));
    block.chain = normals_.chain();
    return block;
  }

 private:
  void count(JoinedBlock& block) const {
    for (std::size_t m = 0; m < models_.size(); ++m) {
      if (!normals_.is_in(m)) continue;
      block.observations += 3 * static_cast<long>(models_[m].points.size());
      block.unknowns += normals_.is_held(m) ? 0 : 7;
    }
    block.unknowns += 3 * static_cast<long>(normals_.chain().points.size());
    for (const SurveyedPoint& point : control_)
      if (normals_.number_of(point) >= 0)
        for (int axis = 0; axis < 3; ++axis) {
          block.unknowns -= point.sigma[axis] == 0 ? 1 : 0;
          block.observations += point.sigma[axis] > 0 && point.has(axis) ? 1 : 0;
        }
    block.squares = normals_.squares();
  }

  Result<> examine_model(std::size_t m, JoinedBlock& block) {
    COLLINEA_TRY(const LocalNormals n, normals_.local(m));
    const MatrixXd q = normals_.covariance_of(m);
    const MatrixXd own = n.inverse + n.coupling * q * n.coupling.transpose();
    JoinedModel& out = block.models[m].emplace();
    out.ground_from_model = inverse(normals_.state(m).model_from_ground);
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
        if (variance > kLeastRedundancy * n.weight(row, row) && numbers[row] > kLeastChecked)
          test.w = weighted[row] / std::sqrt(variance);
      }
    }
    out.redundancy = numbers.sum();
    take_points(m, own, q);
    return {};
  }

  void take_points(std::size_t m, const MatrixXd& own, const MatrixXd& q) {
    Index next_own = normals_.is_held(m) ? 0 : 7, next_shared = 0;
    for (std::size_t i = 0; i < models_[m].points.size(); ++i) {
      const bool is_shared = normals_.shared().numbers(m)[i] >= 0;
      Index& next = is_shared ? next_shared : next_own;
      JoinedPoint& point = points_[models_[m].points[i].name];
      point.name = models_[m].points[i].name;
      point.position = normals_.position(point.name);
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
    constexpr double kRadian = std::numbers::pi / 180;
    out.omega_rad = angles.omega_deg * kRadian;
    out.phi_rad = angles.phi_deg * kRadian;
    out.kappa_rad = angles.kappa_deg * kRadian;
    if (normals_.is_held(m)) return;
    const Vector3d& c = normals_.state(m).centre;
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
  BlockNormals& normals_;
  std::map<std::string, JoinedPoint> points_;
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
  chain = better_start(models, near, std::move(chain), run);
  BlockNormals normals(models, near, std::move(chain), run);
  COLLINEA_TRY(const int steps, normals.settle(options.most_steps));
  COLLINEA_TRY(JoinedBlock block, Examination(models, near, options, normals).examine());
  block.steps = steps;
  for (JoinedPoint& point : block.points) point.position += origin;
  for (auto& model : block.models)
    if (model) model->ground_from_model.translation += origin;
  for (auto& start : block.chain.ground_from_model)
    if (start) start->translation += origin;
  for (auto& [name, position] : block.chain.points) position += origin;
  return block;
}

}  // namespace collinea
