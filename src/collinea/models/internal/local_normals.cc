// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/internal/local_normals.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/geometry/rotation.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kLeastPivot = 1e-12;  // of the factor, squared, relative to the variance

// The inverse of a covariance; nothing where it is singular or has a negative eigenvalue.
std::optional<MatrixXd> inverse_of(const MatrixXd& covariance) {
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  if (!(scale.array() > 0).all()) return std::nullopt;
  const Eigen::VectorXd unscale = scale.cwiseInverse();
  const MatrixXd correlation = unscale.asDiagonal() * covariance * unscale.asDiagonal();
  const Eigen::LLT<MatrixXd> factor(correlation);
  if (factor.info() != Eigen::Success) return std::nullopt;
  if (factor.matrixLLT().diagonal().cwiseAbs2().minCoeff() < kLeastPivot) return std::nullopt;
  MatrixXd inverse = factor.solve(MatrixXd::Identity(covariance.rows(), covariance.cols()));
  return unscale.asDiagonal() * inverse * unscale.asDiagonal();
}

// Independent points are inverted one by one.
std::optional<MatrixXd> inverse_by_points(const StereoModel& model) {
  if (model.covariance.size() > 0) return inverse_of(model.covariance);
  const auto n = static_cast<Index>(model.points.size());
  MatrixXd weight = MatrixXd::Zero(3 * n, 3 * n);
  for (Index i = 0; i < n; ++i) {
    const auto one = inverse_of(model.points[static_cast<std::size_t>(i)].covariance);
    if (!one) return std::nullopt;
    weight.block<3, 3>(3 * i, 3 * i) = *one;
  }
  return weight;
}

}  // namespace

void ModelState::step(const Eigen::Matrix<double, 7, 1>& by) {
  const double factor = std::exp(by[0]);
  const Eigen::Quaterniond turn = rotation_by(by.segment<3>(1));
  model_from_ground = {factor * model_from_ground.scale, (turn * model_from_ground.rotation).normalized(),
                       centre + factor * (turn * (model_from_ground.translation - centre)) + by.tail<3>()};
}

std::optional<LocalNormals> local_normals(const StereoModel& model, const ModelState& state,
                                          const std::vector<Vector3d>& on_ground, const std::vector<bool>& shared,
                                          bool held) {
  const auto n = static_cast<Index>(model.points.size());
  const auto shared_count = static_cast<Index>(std::count(shared.begin(), shared.end(), true));
  const Index parameters = held ? 0 : 7;
  LocalNormals out;
  out.own = MatrixXd::Zero(3 * n, parameters + 3 * (n - shared_count));
  out.shared = MatrixXd::Zero(3 * n, 3 * shared_count);
  out.reduced_obs.resize(3 * n);
  MatrixXd motion(3 * n, 7);
  const Matrix3d turned = state.model_from_ground.scale * state.model_from_ground.rotation.toRotationMatrix();
  double extent = 0;
  for (Index i = 0, next_own = parameters, next_shared = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Vector3d u = state.model_from_ground * on_ground[k], reduced = u - state.centre;
    motion.middleRows<3>(3 * i) << reduced, -skew(reduced), Matrix3d::Identity();
    out.reduced_obs.segment<3>(3 * i) = model.points[k].position - u;
    (shared[k] ? out.shared.block<3, 3>(3 * i, next_shared) : out.own.block<3, 3>(3 * i, next_own)) = turned;
    (shared[k] ? next_shared : next_own) += 3;
    extent += reduced.squaredNorm() / static_cast<double>(n);
  }
  if (!held) out.own.leftCols<7>() = motion;
  auto weight = inverse_by_points(model);
  if (!weight) {
    // The frame was chosen without error: free the seven parameters it was chosen by. They are free anyhow, so that
    // nothing but their own covariance changes (Rao 1967); where they are held, they are held so well.
    const MatrixXd covariance = model.full_covariance();
    const double variance = covariance.diagonal().mean();
    out.gauge.diagonal() << Eigen::Vector4d::Constant(variance / std::max(extent, 1e-300)),
        Vector3d::Constant(variance);
    weight = inverse_of(covariance + motion * out.gauge * motion.transpose());
  }
  if (!weight) return std::nullopt;
  out.weight = std::move(*weight);
  const MatrixXd weighted_own = out.weight * out.own, weighted_shared = out.weight * out.shared;
  out.reduced_matrix = out.shared.transpose() * weighted_shared;
  out.reduced_right = weighted_shared.transpose() * out.reduced_obs;
  if (out.own.cols() == 0) {
    out.inverse.resize(0, 0);
    out.coupling.resize(0, out.shared.cols());
    out.start.resize(0);
    return out;
  }
  auto inverse = inverse_of(out.own.transpose() * weighted_own);
  if (!inverse) return std::nullopt;
  out.inverse = std::move(*inverse);
  out.coupling = out.inverse * (weighted_own.transpose() * out.shared);
  out.start = out.inverse * (weighted_own.transpose() * out.reduced_obs);
  out.reduced_matrix -= (weighted_shared.transpose() * out.own) * out.coupling;
  out.reduced_right -= (weighted_shared.transpose() * out.own) * out.start;
  return out;
}

}  // namespace collinea
