// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/geometry/absolute_control.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {

/// What a control point says against the others, component by component (X, Y, Z); zero where it is not known.
struct ControlResidual {
  Eigen::Vector3d misfit = Eigen::Vector3d::Zero();      ///< given minus computed from the model, on the ground
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();       ///< of the misfit after adjustment, by the stated sigmas
  Eigen::Vector3d redundancy = Eigen::Vector3d::Zero();  ///< local: their sum is that of the whole
  Eigen::Vector3d w = Eigen::Vector3d::Zero();           ///< Baarda's test by the stated sigmas; 0 where nothing checks
  Eigen::Vector3d model_correction = Eigen::Vector3d::Zero(), ground_correction = Eigen::Vector3d::Zero();
};

/// The similarity with seven parameters between a model and the ground, with its covariance.
struct AbsoluteOrientation {
  using Matrix7 = Eigen::Matrix<double, 7, 7>;

  Similarity3 ground_from_model;
  Eigen::Vector3d centroid_in_model = Eigen::Vector3d::Zero();  ///< about which the parameters are nearly independent
  /// Of [ground position of the centroid, rotation about the axes of the ground (rad), ln scale], by stated sigmas.
  Matrix7 covariance = Matrix7::Zero();
  int redundancy = 0;
  double sigma0 = 1;  ///< a posteriori, of unit weight; 1 without redundancy
  int iterations = 0;
  int solutions = 1;  ///< that fit the control equally well; of several this is the one that tilts the model least
  std::vector<ControlResidual> residuals;
};

struct AbsoluteOptions {
  std::optional<Similarity3> start = {};  ///< nothing: by align(), or where full points are too few, by search
  /// Of the model coordinates of all points in their order, 3n x 3n, in place of those of the single points.
  const Eigen::MatrixXd* model_covariance = nullptr;
};

/// Absolute orientation by least squares in the Gauss-Helmert model: both sides have errors,
///     X + vX = T + m R (u + vu),   weights by  W = C_X + m^2 R C_u R',
/// linearised at the adjusted model coordinates; iterated to 1e-12. Seven unknowns; two points in plan and three in
/// height at least (two full ones and a height), not on a line. Without three full points the rotation about the line
/// of two full ones, or for less a start with the model's w axis upright, is searched.
///
/// Errors (ill-posed): too few components; points that leave a parameter open (the smallest eigenvalue of the normal
/// matrix with unit diagonal is below 1e-11); covariances that are not positive definite; not converged.
[[nodiscard]] Result<AbsoluteOrientation> absolute_orientation(std::span<const AbsoluteControl> pairs,
                                                               const AbsoluteOptions& options = {});

/// The ground position of a point of the model and its covariance: by the orientation's and by the model's own, taken
/// as independent of the control.
struct GroundPoint {
  Eigen::Vector3d position;
  Eigen::Matrix3d covariance;
};
[[nodiscard]] GroundPoint on_ground(const AbsoluteOrientation& orientation, const Eigen::Vector3d& in_model,
                                    const Eigen::Matrix3d& model_covariance = Eigen::Matrix3d::Zero());

/// The parameters that people read: u = (1/m) R (X - T), R = Rz(kappa) Ry(phi) Rx(omega).
struct AbsoluteParameters {
  Eigen::Vector3d origin_on_ground;         ///< T, where the model's origin lies
  double omega_rad, phi_rad, kappa_rad;     ///< Cardan angles of the model on the ground
  double scale;                             ///< m, ground over model
  AbsoluteOrientation::Matrix7 covariance;  ///< of these seven, in this order
};
[[nodiscard]] AbsoluteParameters parameters_of(const AbsoluteOrientation& orientation);

/// The indices of full points that contradict the least median of squares of all triples (of 500 drawn ones where
/// there are more): beyond 3 robust standard deviations on each axis and `sigma` of their own. Nothing with fewer than
/// four full points, or when those that agree lie on a line.
[[nodiscard]] std::optional<std::vector<std::size_t>> contradicting_control(std::span<const AbsoluteControl> pairs,
                                                                            std::uint64_t seed);

}  // namespace collinea
