// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/scaled_pair.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace collinea {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Distances in the model of base 1 with their derivatives by the orientation and by their end points.
struct ModelDistances {
  Eigen::VectorXd length;
  Eigen::Matrix<double, Eigen::Dynamic, 5> by_orientation;
  Eigen::MatrixXd own;  // covariance by what the end points do not share with the orientation
};

bool is_usable(const PairDistance& d, const PairModel& model) {
  const auto has = [&](int i) {
    return i >= 0 && i < static_cast<int>(model.points.size()) && model.points[static_cast<std::size_t>(i)];
  };
  return has(d.from) && has(d.to) && d.from != d.to && d.sigma > 0 && d.length > 0 && std::isfinite(d.length) &&
         std::isfinite(d.sigma);
}

ModelDistances model_distances(const PairModel& model, std::span<const PairDistance> distances,
                               const Matrix5& orientation) {
  const auto count = static_cast<Eigen::Index>(distances.size());
  ModelDistances out{Eigen::VectorXd(count), {count, 5}, Eigen::MatrixXd::Zero(count, count)};
  std::vector<Eigen::Vector3d> directions;
  for (Eigen::Index k = 0; k < count; ++k) {
    const PairDistance& d = distances[static_cast<std::size_t>(k)];
    const ModelPoint &from = *model.points[static_cast<std::size_t>(d.from)],
                     &to = *model.points[static_cast<std::size_t>(d.to)];
    const Eigen::Vector3d between = to.position - from.position;
    out.length(k) = between.norm();
    directions.emplace_back(between / out.length(k));
    out.by_orientation.row(k) = directions.back().transpose() * (to.by_orientation - from.by_orientation);
  }
  // Distances that end in one point share its errors.
  for (Eigen::Index k = 0; k < count; ++k)
    for (Eigen::Index l = 0; l < count; ++l) {
      const PairDistance &a = distances[static_cast<std::size_t>(k)], &b = distances[static_cast<std::size_t>(l)];
      for (const int i : {a.from, a.to})
        for (const int j : {b.from, b.to}) {
          if (i != j) continue;
          const ModelPoint& point = *model.points[static_cast<std::size_t>(i)];
          const Eigen::Matrix3d own =
              point.covariance - point.by_orientation * orientation * point.by_orientation.transpose();
          const double sign = (i == a.to) == (j == b.to) ? 1 : -1;
          out.own(k, l) +=
              sign * directions[static_cast<std::size_t>(k)].dot(own * directions[static_cast<std::size_t>(l)]);
        }
    }
  return out;
}

// The model of the pair as it is now, with the covariance of its base in all points.
PairModel with_base(const RelativeOrientation& orientation, std::span<const PairPoint> points, const ScaledPair& pair,
                    bool y_up) {
  PairModel model = model_points(orientation, points, pair.base, y_up);
  const Eigen::Matrix<double, 5, 1> with_orientation = pair.covariance.topRightCorner<5, 1>();
  const auto add = [&](ModelPoint& point) {
    const Eigen::Vector3d by_base = point.position / pair.base;
    const Eigen::Matrix3d cross = point.by_orientation * with_orientation * by_base.transpose();
    point.covariance += pair.covariance(5, 5) * by_base * by_base.transpose() + cross + cross.transpose();
  };
  for (auto& point : model.points)
    if (point) add(*point);
  add(model.second_centre);
  return model;
}

}  // namespace

std::optional<ScaledPair> scaled_pair(const RelativeOrientation& orientation, std::span<const PairPoint> points,
                                      std::span<const PairDistance> distances, bool y_up) {
  const Matrix5 known = orientation.stated_covariance();
  const PairModel unit = model_points(orientation, points);
  if (distances.empty()) return std::nullopt;
  for (const PairDistance& d : distances)
    if (!is_usable(d, unit)) return std::nullopt;
  const ModelDistances model = model_distances(unit, distances, known);
  if (!(model.length.minCoeff() > 0)) return std::nullopt;

  const auto count = static_cast<Eigen::Index>(distances.size());
  Eigen::VectorXd measured(count), variances(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    measured(k) = distances[static_cast<std::size_t>(k)].length;
    variances(k) = std::pow(distances[static_cast<std::size_t>(k)].sigma, 2);
  }
  ScaledPair out;
  out.base = measured.sum() / model.length.sum();
  Vector6 x = Vector6::Zero();
  Eigen::MatrixXd design(count, 6), covariance(count, count);
  Matrix6 inverse;
  for (int i = 0; i < 4; ++i) {  // the base stands in the weights and in the derivatives
    design << out.base * model.by_orientation, model.length;
    covariance = Eigen::MatrixXd(variances.asDiagonal()) + out.base * out.base * model.own;
    const Eigen::LLT<Eigen::MatrixXd> weights(covariance);
    Matrix6 normal = design.transpose() * weights.solve(design);
    normal.topLeftCorner<5, 5>() += known.inverse();
    const Eigen::LLT<Matrix6> solver(normal);
    if (weights.info() != Eigen::Success || solver.info() != Eigen::Success) return std::nullopt;
    inverse = solver.solve(Matrix6::Identity());
    // Unknowns are the change of the orientation from that of the conditions, and the base itself.
    x = inverse * (design.transpose() * weights.solve(measured));
    out.base = x(5);
    if (!(out.base > 0)) return std::nullopt;
  }
  const Eigen::VectorXd residuals = design * x - measured;
  const Eigen::MatrixXd of_residuals =
      covariance + out.base * out.base * model.by_orientation * known * model.by_orientation.transpose();
  // The orientation counts as observed: residuals of the distances against what the conditions predict.
  const Eigen::VectorXd misclosures = measured - out.base * model.length;
  const Eigen::LLT<Eigen::MatrixXd> predicted(of_residuals);
  const double squares = misclosures.dot(predicted.solve(misclosures));
  const double of_length = model.length.dot(predicted.solve(model.length));
  out.redundancy = static_cast<double>(count - 1);
  out.sigma0 = count > 1 ? std::sqrt(squares / out.redundancy) : 0;
  const Eigen::MatrixXd after = of_residuals - model.length * model.length.transpose() / of_length;
  const Eigen::VectorXd weighted = predicted.solve(misclosures);
  const Eigen::MatrixXd weight_after = predicted.solve(predicted.solve(after).transpose());
  for (Eigen::Index k = 0; k < count; ++k) {
    out.residuals.push_back(residuals(k));
    const double variance = weight_after(k, k);
    out.standardised.push_back(count > 1 && variance > 1e-12 / of_residuals(k, k) ? -weighted(k) / std::sqrt(variance)
                                                                                  : 0);
  }
  out.covariance = inverse;
  RelativeOrientation scaled = orientation;
  scaled.second_from_first = changed(orientation.second_from_first, x.head<5>());
  scaled.covariance = inverse.topLeftCorner<5, 5>() / orientation.variance_factor;
  out.second_from_first = scaled.second_from_first;
  out.model = with_base(scaled, points, out, y_up);
  return out;
}

}  // namespace collinea
