// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/plane_similarity.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/math/least_median.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix4d;
using Eigen::Vector2d;
using Eigen::Vector4d;
using Matrix24 = Eigen::Matrix<double, 2, 4>;

Matrix2d scaled_rotation(double c, double s) { return Matrix2d{{c, -s}, {s, c}}; }

// Equations of one point: unknowns are the shift at the centroid, scale cos and scale sin.
struct Equations {
  Matrix24 design;
  Vector2d measured;
  Matrix2d covariance;
};

Equations equations_of(const PlanePair& pair, const Vector2d& mean_a, const Vector2d& mean_b, const Matrix2d& turned) {
  const Vector2d u = pair.in_a - mean_a;
  Equations e;
  e.design << 1, 0, u.x(), -u.y(), 0, 1, u.y(), u.x();
  e.measured = pair.in_b - mean_b;
  e.covariance = pair.covariance_b + turned * pair.covariance_a * turned.transpose();
  return e;
}

// Through two points of each side, as complex numbers: (b2 - b1) / (a2 - a1).
std::optional<PlaneSimilarity> through_two(const PlanePair& first, const PlanePair& second) {
  const Vector2d a = second.in_a - first.in_a, b = second.in_b - first.in_b;
  if (!(a.squaredNorm() > 0 && b.squaredNorm() > 0)) return std::nullopt;
  PlaneSimilarity out{Vector2d::Zero(), b.norm() / a.norm(), std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)),
                      Matrix4d::Zero()};
  out.shift = first.in_b - out.matrix() * first.in_a;
  return out;
}

std::vector<double> distances(std::span<const PlanePair> pairs, const PlaneSimilarity& b_from_a) {
  std::vector<double> out;
  for (const PlanePair& pair : pairs) out.push_back((pair.in_b - b_from_a * pair.in_a).norm());
  return out;
}

// Of a coordinate, by the h-th smallest distance.
double robust_scale(std::vector<double> distances) {
  const std::size_t n = distances.size(), h = median_rank(n, 2) - 1;
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(h), distances.end());
  return robust_sigma(distances[h], n, 2, 2);
}

// The similarity with the least scale over pairs of points: all, or `most` drawn ones.
std::optional<PlaneSimilarity> least_median(std::span<const PlanePair> pairs, std::size_t most, std::uint64_t seed) {
  std::optional<PlaneSimilarity> best;
  double least = std::numeric_limits<double>::infinity();
  const auto attempt = [&](std::size_t i, std::size_t j) {
    const auto candidate = through_two(pairs[i], pairs[j]);
    if (!candidate) return;
    if (const double scale = robust_scale(distances(pairs, *candidate)); scale < least) {
      least = scale;
      best = candidate;
    }
  };
  const std::size_t n = pairs.size();
  if (n * (n - 1) / 2 <= most) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j) attempt(i, j);
    return best;
  }
  Random random(seed);
  for (std::size_t trial = 0; trial < most; ++trial) {
    const auto i = random.below(static_cast<std::uint32_t>(n)), j = random.below(static_cast<std::uint32_t>(n));
    if (i != j) attempt(i, j);
  }
  return best;
}

// Standard deviation of a coordinate of a pair's misfit.
double own_sigma(const PlanePair& pair, const PlaneSimilarity& b_from_a) {
  return std::sqrt((pair.covariance_b.trace() + b_from_a.scale * b_from_a.scale * pair.covariance_a.trace()) / 2);
}

}  // namespace

Matrix2d PlaneSimilarity::matrix() const {
  return scaled_rotation(scale * std::cos(angle_rad), scale * std::sin(angle_rad));
}

Vector2d operator*(const PlaneSimilarity& b_from_a, const Vector2d& point_in_a) {
  return b_from_a.shift + b_from_a.matrix() * point_in_a;
}

PlaneSimilarity inverse(const PlaneSimilarity& b_from_a) {
  PlaneSimilarity a{Vector2d::Zero(), 1 / b_from_a.scale, -b_from_a.angle_rad, Matrix4d::Zero()};
  a.shift = -(a.matrix() * b_from_a.shift);
  const Matrix2d quarter{{0, -1}, {1, 0}};
  Matrix4d by = Matrix4d::Zero();  // of the inverse's parameters by those of the similarity
  by.topLeftCorner<2, 2>() = -a.matrix();
  by.block<2, 1>(0, 2) = -a.shift / b_from_a.scale;
  by.block<2, 1>(0, 3) = -(quarter * a.shift);
  by(2, 2) = -a.scale / b_from_a.scale;
  by(3, 3) = -1;
  a.covariance = by * b_from_a.covariance * by.transpose();
  return a;
}

std::optional<PlaneSimilarityFit> fit_plane_similarity(std::span<const PlanePair> pairs) {
  if (pairs.size() < 2) return std::nullopt;
  Vector2d mean_a = Vector2d::Zero(), mean_b = Vector2d::Zero();
  for (const PlanePair& pair : pairs) {
    mean_a += pair.in_a / double(pairs.size());
    mean_b += pair.in_b / double(pairs.size());
  }
  Vector4d x(0, 0, 1, 0);
  Matrix4d inverse_normal;
  std::vector<Equations> equations(pairs.size());
  std::vector<Matrix2d> weights(pairs.size());
  for (int round = 0; round < 6; ++round) {  // the first finds the scale of the weights
    Matrix4d normal = Matrix4d::Zero();
    Vector4d right = Vector4d::Zero();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      equations[i] = equations_of(pairs[i], mean_a, mean_b, scaled_rotation(x[2], x[3]));
      const Eigen::LLT<Matrix2d> factor(equations[i].covariance);
      if (factor.info() != Eigen::Success || !(equations[i].covariance.trace() > 0)) return std::nullopt;
      weights[i] = factor.solve(Matrix2d::Identity());
      normal += equations[i].design.transpose() * weights[i] * equations[i].design;
      right += equations[i].design.transpose() * weights[i] * equations[i].measured;
    }
    const Vector4d unit = normal.diagonal().cwiseSqrt().cwiseInverse();
    if (!unit.allFinite()) return std::nullopt;
    const Eigen::LDLT<Matrix4d> factor(unit.asDiagonal() * normal * unit.asDiagonal());
    if (!(factor.vectorD().minCoeff() > 1e-12)) return std::nullopt;
    inverse_normal = unit.asDiagonal() * factor.solve(Matrix4d(unit.asDiagonal()));
    x = inverse_normal * right;
  }
  const double scale = std::hypot(x[2], x[3]);
  if (!(scale > 0)) return std::nullopt;
  PlaneSimilarityFit fit;
  fit.b_from_a = {Vector2d::Zero(), scale, std::atan2(x[3], x[2]), Matrix4d::Zero()};
  fit.b_from_a.shift = mean_b + x.head<2>() - fit.b_from_a.matrix() * mean_a;
  Matrix4d by = Matrix4d::Zero();  // of shift, scale, angle by x
  by.topLeftCorner<2, 2>().setIdentity();
  by.block<2, 2>(0, 2) << -mean_a.x(), mean_a.y(), -mean_a.y(), -mean_a.x();
  by.block<2, 2>(2, 2) << x[2] / scale, x[3] / scale, -x[3] / (scale * scale), x[2] / (scale * scale);
  fit.b_from_a.covariance = by * inverse_normal * by.transpose();
  double squares = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vector2d misfit = equations[i].measured - equations[i].design * x;
    const Matrix2d left =
        equations[i].covariance - equations[i].design * inverse_normal * equations[i].design.transpose();
    const Matrix2d redundancy = left * weights[i], of_multipliers = weights[i] * redundancy;
    const Vector2d multipliers = weights[i] * misfit;
    fit.misfits.push_back(misfit);
    fit.sigmas.push_back(left.diagonal().cwiseMax(0).cwiseSqrt());
    fit.redundancies.push_back(redundancy.diagonal().cwiseMax(0));
    Vector2d w = Vector2d::Zero();
    for (int k = 0; k < 2; ++k)
      if (of_multipliers(k, k) > 1e-9 * weights[i](k, k)) w[k] = multipliers[k] / std::sqrt(of_multipliers(k, k));
    fit.w.push_back(w);
    squares += misfit.dot(multipliers);
  }
  fit.redundancy = 2 * static_cast<int>(pairs.size()) - 4;
  if (fit.redundancy > 0) fit.sigma0 = std::sqrt(squares / fit.redundancy);
  return fit;
}

std::optional<std::vector<std::size_t>> contradicting_in_plane(std::span<const PlanePair> pairs, std::uint64_t seed) {
  if (pairs.size() < 4) return std::nullopt;
  auto best = least_median(pairs, 500, seed);
  if (!best) return std::nullopt;
  std::vector<std::size_t> wrong;
  for (int round = 0; round < 3; ++round) {
    const std::vector<double> off = distances(pairs, *best);
    const double scale = robust_scale(off);
    std::vector<PlanePair> right;
    wrong.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (off[i] <= wrong_beyond(2) * std::max(scale, own_sigma(pairs[i], *best)))
        right.push_back(pairs[i]);
      else
        wrong.push_back(i);
    const auto fit = fit_plane_similarity(right);
    if (!fit) return std::nullopt;
    best = fit->b_from_a;
  }
  return wrong;
}

}  // namespace collinea
