// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <vector>

namespace collinea {

/// Normal equations of 3-vectors x_i with conditions on single ones and on differences x_second - x_first, solved by
/// conjugate gradients with the diagonal blocks as preconditioner. The sums have one order: the same bits everywhere.
class SparseNormals {
 public:
  explicit SparseNormals(std::size_t count)
      : diagonal_(count, Eigen::Matrix3d::Zero()), right_(count, Eigen::Vector3d::Zero()) {}

  /// weight: symmetric, at least semidefinite.
  void add_value(std::size_t i, const Eigen::Matrix3d& weight, const Eigen::Vector3d& value) {
    diagonal_[i] += weight;
    right_[i] += weight * value;
  }
  void add_difference(std::size_t first, std::size_t second, const Eigen::Matrix3d& weight,
                      const Eigen::Vector3d& difference) {
    diagonal_[first] += weight;
    diagonal_[second] += weight;
    right_[first] -= weight * difference;
    right_[second] += weight * difference;
    ties_.push_back({first, second, weight});
  }

  /// From `x` on, until the residual has fallen to `tolerance` of what it was for x = 0.
  void solve(std::vector<Eigen::Vector3d>& x, double tolerance, int max_iterations) const {
    const std::size_t n = diagonal_.size();
    std::vector<Eigen::Matrix3d> inverse(n);
    for (std::size_t i = 0; i < n; ++i)
      inverse[i] = (diagonal_[i] + (1e-9 * diagonal_[i].trace() + 1e-12) * Eigen::Matrix3d::Identity()).inverse();
    std::vector<Eigen::Vector3d> r = times(x), z(n), p(n);
    double wanted = 0, rz = 0;
    for (std::size_t i = 0; i < n; ++i) {
      r[i] = right_[i] - r[i];
      p[i] = z[i] = inverse[i] * r[i];
      rz += r[i].dot(z[i]);
      wanted += right_[i].dot(inverse[i] * right_[i]);
    }
    wanted *= tolerance * tolerance;
    for (int iteration = 0; iteration < max_iterations && rz > wanted && rz > 0; ++iteration) {
      const std::vector<Eigen::Vector3d> q = times(p);
      double pq = 0;
      for (std::size_t i = 0; i < n; ++i) pq += p[i].dot(q[i]);
      if (!(pq > 0)) return;
      const double alpha = rz / pq;
      double next = 0;
      for (std::size_t i = 0; i < n; ++i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
        z[i] = inverse[i] * r[i];
        next += r[i].dot(z[i]);
      }
      for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + next / rz * p[i];
      rz = next;
    }
  }

 private:
  struct Tie {
    std::size_t first, second;
    Eigen::Matrix3d weight;
  };

  [[nodiscard]] std::vector<Eigen::Vector3d> times(const std::vector<Eigen::Vector3d>& x) const {
    std::vector<Eigen::Vector3d> y(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = diagonal_[i] * x[i];
    for (const Tie& tie : ties_) {
      y[tie.first] -= tie.weight * x[tie.second];
      y[tie.second] -= tie.weight * x[tie.first];
    }
    return y;
  }

  std::vector<Eigen::Matrix3d> diagonal_;
  std::vector<Eigen::Vector3d> right_;
  std::vector<Tie> ties_;
};

}  // namespace collinea
