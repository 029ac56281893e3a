// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "collinea/feature/edge_map.h"

// Curves through points of edges by least squares. Each point measures across its edge; the weight is 1 / sigma^2.
// Neighbouring points have noise in common (EdgeMap::along_px), therefore
//     covariance = N^-1 A' P C P A N^-1,   N = A' P A,   redundancy = n - tr(N^-1 A' P C P A),
// C being the covariance of the points with correlations exp(-d^2 / (4 along^2)) cos(angle of the normals).
namespace collinea {

/// What an adjustment of edge points is worth.
struct EdgeFitQuality {
  double sigma0 = 0;      ///< of unit weight, from residuals; 0 without redundancy
  double redundancy = 0;  ///< what the points have beyond the unknowns, less for their correlation
  double rms_px = 0;      ///< of residuals across the edge
  /// The residuals are larger than their standard deviations allow (chi-squared, level 0.001): the curve is not that of
  /// the model, or the noise is not white. Covariances are then multiplied by sigma0^2.
  bool is_scaled = false;
};

/// One step: corrections of the unknowns for misclosures (point minus curve, across) with the derivatives `design`.
struct EdgeStep {
  Eigen::VectorXd correction;
  Eigen::MatrixXd covariance;  ///< of the unknowns
  EdgeFitQuality quality;
};
/// Nothing when the points do not determine the unknowns (rank).
[[nodiscard]] std::optional<EdgeStep> adjust_edge_points(std::span<const EdgePoint> points, double along_px,
                                                         const Eigen::MatrixXd& design,
                                                         const Eigen::VectorXd& misclosure);

/// How much of a closed curve has points [rad], given where each lies on it as an angle: 2 pi less the gaps of more
/// than 3 px between neighbours.
[[nodiscard]] double covered_arc(std::span<const EdgePoint> points, const std::vector<double>& angles_rad);

/// The straight line x cos(theta) + y sin(theta) = r.
struct EdgeLine {
  double theta_rad = 0;  ///< of the normal, towards what is brighter; -pi .. pi, from x to y
  double r_px = 0;       ///< distance from the upper left corner of the image, negative where the normal points to it
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of theta [rad], r [px]
  Eigen::Vector2d from = {}, to = {};                    ///< the feet of its outermost points
  EdgeFitQuality quality;

  [[nodiscard]] Eigen::Vector2d normal() const { return {std::cos(theta_rad), std::sin(theta_rad)}; }
  [[nodiscard]] double length_px() const { return (to - from).norm(); }
  [[nodiscard]] double distance_px(const Eigen::Vector2d& p) const { return normal().dot(p) - r_px; }
};
/// Nothing from fewer than two points, or from points at one position.
[[nodiscard]] std::optional<EdgeLine> fit_line(std::span<const EdgePoint> points, double along_px);

/// A circle.
struct EdgeCircle {
  Eigen::Vector2d centre = {};
  double radius_px = 0;
  bool is_bright = false;                                ///< brighter inside than outside
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of centre x, y, radius [px]
  double arc_rad = 0;                                    ///< how much of it has points, of 2 pi
  EdgeFitQuality quality;
};
/// Nothing from fewer than three points, from points on a line, where the iteration does not end.
[[nodiscard]] std::optional<EdgeCircle> fit_circle(std::span<const EdgePoint> points, double along_px);

}  // namespace collinea
