// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/quality/internal/error_mixture.h"

namespace collinea {

/// The rays of one tie point around its adjusted position, poses and cameras being known: linear equations by which
/// rays can be left out and the point be intersected anew. That the rays of the point have a part in poses and cameras
/// is not looked at: of a block with hundreds of rays an image it is a percent of what they have in the point.
class PointRays {
 public:
  /// Of a tie point of the problem. Rays that do not see the point are not among them.
  PointRays(const bundle::Problem& problem, const bundle::State& state, std::size_t point);

  [[nodiscard]] std::size_t size() const { return rays_.size(); }
  /// Index in Block::observations.
  [[nodiscard]] std::uint32_t source(std::size_t ray) const { return rays_[ray].source; }
  void leave_out(std::size_t ray) { rays_.erase(rays_.begin() + static_cast<std::ptrdiff_t>(ray)); }

  /// The errors of the rays when all of them intersect the point by least squares, in the order of the rays: with
  /// u_i, lambda_i eigenvectors and eigenvalues of a ray's redundancy I - A N^-1 A' (2 x 2), the sum of
  /// (u_i' v)^2 / lambda_i over those of 0.05 and more. Empty when they do not determine the point.
  [[nodiscard]] std::vector<CheckedError> errors() const;

 private:
  struct Measured {
    std::uint32_t source;
    Eigen::Vector2d residual;              // at the adjusted position [sigmas]
    Eigen::Matrix<double, 2, 3> by_point;  // of what is computed [sigmas / m]
  };
  std::vector<Measured> rays_;
  bool is_fixed_;
};

/// The error of a residual [sigmas] by its 2 x 2 matrix of redundancy, as above. `weight`: of a robust loss, of which
/// the redundancy is; the error is that of the ray as the others predict it.
[[nodiscard]] CheckedError checked_error(const Eigen::Vector2d& residual, const Eigen::Matrix2d& redundancy,
                                         double weight = 1);

}  // namespace collinea
