// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/covariance_likelihood.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Index;
using Eigen::Vector3d;  // logarithms of signal, range and noise

constexpr std::size_t kMostPoints = 400, kNeighbours = 14;
constexpr double kNoNoise = 1e-8, kRegular = 1e-6;  // the latter of the signal, as collocation has it
constexpr double kFirstStep = 0.7, kLastStep = 0.02;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// A point after its neighbours: distances of all pairs, variances of the sigmas, heights.
struct Conditional {
  Eigen::MatrixXd distances;
  Eigen::VectorXd variances, heights;
};

std::vector<std::size_t> shuffled(std::size_t size) {
  const std::size_t stride = (size + kMostPoints - 1) / kMostPoints;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < size; i += stride) order.push_back(i);
  Random random(1);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
  return order;
}

std::vector<Conditional> conditionals(std::span<const HeightPoint> points, std::span<const double> heights) {
  const std::vector<std::size_t> order = shuffled(points.size());
  std::vector<Conditional> all;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const auto distance = [&](std::size_t a, std::size_t b) {
      return (points[a].position.head<2>() - points[b].position.head<2>()).norm();
    };
    std::vector<std::size_t> near(order.begin(), order.begin() + std::ptrdiff_t(k));
    std::stable_sort(near.begin(), near.end(),
                     [&](std::size_t a, std::size_t b) { return distance(a, order[k]) < distance(b, order[k]); });
    near.resize(std::min(near.size(), kNeighbours));
    near.push_back(order[k]);
    const auto n = Index(near.size());
    Conditional one{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd(n), Eigen::VectorXd(n)};
    for (Index i = 0; i < n; ++i) {
      one.variances[i] = points[near[std::size_t(i)]].sigma_m * points[near[std::size_t(i)]].sigma_m;
      one.heights[i] = heights[near[std::size_t(i)]];
      for (Index j = 0; j < i; ++j) one.distances(i, j) = distance(near[std::size_t(i)], near[std::size_t(j)]);
    }
    all.push_back(std::move(one));
  }
  return all;
}

// By the last row of the Cholesky factor: the point given its neighbours.
double minus_log_likelihood(const std::vector<Conditional>& all, const HeightCovariance& covariance) {
  double sum = 0;
  for (const Conditional& one : all) {
    const Index n = one.heights.size();
    Eigen::MatrixXd matrix(n, n);
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < i; ++j) matrix(i, j) = covariance.at(one.distances(i, j));
      matrix(i, i) = covariance.signal_m2 * (1 + kRegular) + covariance.noise_m2 + one.variances[i];
    }
    const Eigen::LLT<Eigen::MatrixXd> factors(matrix);  // of the lower half
    if (factors.info() != Eigen::Success) return kInfinite;
    const Eigen::VectorXd whitened = factors.matrixL().solve(one.heights);
    const double spread = factors.matrixLLT()(n - 1, n - 1);
    if (!(spread > 0)) return kInfinite;
    sum += std::log(spread) + whitened[n - 1] * whitened[n - 1] / 2;
  }
  return sum;
}

}  // namespace

LikelyCovariance most_likely(std::span<const HeightPoint> points, std::span<const double> heights,
                             const HeightCovariance& start, double least_range_m, double most_range_m) {
  const double mean_square = std::inner_product(heights.begin(), heights.end(), heights.begin(), 0.0) /
                             double(std::max<std::size_t>(heights.size(), 1));
  if (!(start.signal_m2 > 0) || !(mean_square > 1e-20)) return {start, kInfinite};
  const std::vector<Conditional> all = conditionals(points, heights);
  const Vector3d low(std::log(1e-4 * mean_square), std::log(least_range_m), std::log(kNoNoise * mean_square)),
      high(std::log(1e4 * mean_square), std::log(most_range_m), std::log(mean_square));
  const auto covariance_at = [&](const Vector3d& at) {
    return HeightCovariance{start.model, std::exp(at[0]), std::exp(at[1]), at[2] > low[2] ? std::exp(at[2]) : 0};
  };
  Vector3d at(std::log(start.signal_m2), std::log(start.range_m),
              std::log(std::max(start.noise_m2, 1e-4 * start.signal_m2)));
  at = at.cwiseMax(low).cwiseMin(high);
  double least = minus_log_likelihood(all, covariance_at(at));
  // Pattern search: each of the three, and signal with range, which rise together along a valley of smooth surfaces.
  const Vector3d directions[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 3}, {2, 1, 0}, {1, 1, 0}};
  for (double step = kFirstStep; step > kLastStep;) {
    bool is_better = false;
    for (const Vector3d& direction : directions)
      for (const double sign : {1.0, -1.0}) {
        const Vector3d tried = (at + sign * step * direction).cwiseMax(low).cwiseMin(high);
        if (tried == at) continue;
        const double value = minus_log_likelihood(all, covariance_at(tried));
        if (!(value < least - 1e-6)) continue;
        least = value;
        at = tried;
        is_better = true;
        break;
      }
    if (!is_better) step /= 2;
  }
  return {covariance_at(at), least};
}

}  // namespace collinea
