// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace collinea {

/// A motion of the plane with change of scale (Casella; Franco 4): x = shift + scale R(angle) u,
/// R = [cos -sin; sin cos], counter-clockwise.
struct PlaneSimilarity {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double scale = 1, angle_rad = 0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  ///< of [shift, scale, angle (rad)]

  [[nodiscard]] Eigen::Matrix2d matrix() const;  ///< scale R
};

[[nodiscard]] Eigen::Vector2d operator*(const PlaneSimilarity& b_from_a, const Eigen::Vector2d& point_in_a);
/// The inverse, with the covariance of its own parameters.
[[nodiscard]] PlaneSimilarity inverse(const PlaneSimilarity& b_from_a);

/// A point in both planes, each side with its covariance; not both zero.
struct PlanePair {
  Eigen::Vector2d in_a, in_b;
  Eigen::Matrix2d covariance_a = Eigen::Matrix2d::Zero(), covariance_b = Eigen::Matrix2d::Identity();
};

struct PlaneSimilarityFit {
  PlaneSimilarity b_from_a;  ///< covariance by the stated ones
  int redundancy = 0;
  double sigma0 = 1;                                  ///< 1 without redundancy
  std::vector<Eigen::Vector2d> misfits;               ///< in b, given minus computed
  std::vector<Eigen::Vector2d> sigmas, redundancies;  ///< of the misfits
  std::vector<Eigen::Vector2d> w;                     ///< Baarda's test; 0 where nothing checks
};

/// By least squares; linear in scale cos and scale sin, repeated for the weights C_b + scale^2 R C_a R'. Four unknowns:
/// two points at least. Nothing when all points of a side coincide, or weights are not positive definite.
[[nodiscard]] std::optional<PlaneSimilarityFit> fit_plane_similarity(std::span<const PlanePair> pairs);

/// The indices of points that contradict the least median of squares over pairs of points (all, or 500 drawn ones): off
/// the similarity of those that agree by more than 3.04 robust standard deviations of a coordinate and of their own, as
/// one of 100 right ones is. Of n points n - [n/2] - 1 may be wrong. Nothing with fewer than four, or when those that
/// agree coincide.
[[nodiscard]] std::optional<std::vector<std::size_t>> contradicting_in_plane(std::span<const PlanePair> pairs,
                                                                             std::uint64_t seed);

}  // namespace collinea
