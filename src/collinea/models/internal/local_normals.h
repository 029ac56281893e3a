// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/geometry/similarity3.h"
#include "collinea/models/stereo_model.h"

namespace collinea {

/// A model's seven parameters as increments about the centroid c of its coordinates u = s Q X + d:
///     du = eps (u - c) + omega x (u - c) + tau,    order: eps, omega, tau
struct ModelState {
  Similarity3 model_from_ground;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();

  void step(const Eigen::Matrix<double, 7, 1>& by);
};

/// What a model contributes to the block: observations l = A y + B x + v, where y are the unknowns that it has for
/// itself (its parameters, unless they are held, then the coordinates of points that are its own) and x those of shared
/// points. y is eliminated.
struct LocalNormals {
  Eigen::MatrixXd weight;                                                   ///< P, inverse of the covariance
  Eigen::MatrixXd own, shared;                                              ///< A, B
  Eigen::VectorXd reduced_obs;                                              ///< l, observed minus computed
  Eigen::MatrixXd inverse;                                                  ///< (A'PA)^-1
  Eigen::MatrixXd coupling;                                                 ///< (A'PA)^-1 A'PB: y = start - coupling x
  Eigen::VectorXd start;                                                    ///< (A'PA)^-1 A'P l
  Eigen::MatrixXd reduced_matrix;                                           ///< B'PB - B'PA coupling
  Eigen::VectorXd reduced_right;                                            ///< B'P (l - A start)
  Eigen::Matrix<double, 7, 7> gauge = Eigen::Matrix<double, 7, 7>::Zero();  ///< added to the covariance of y's first 7
};

/// `shared`: of each point of the model, whether it is an unknown of the block. Nothing: the covariance is not positive
/// semidefinite, or singular by more than the choice of the frame.
[[nodiscard]] std::optional<LocalNormals> local_normals(const StereoModel& model, const ModelState& state,
                                                        const std::vector<Eigen::Vector3d>& on_ground,
                                                        const std::vector<bool>& shared, bool held);

}  // namespace collinea
