// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <span>
#include <vector>

#include "collinea/geometry/absolute_control.h"

namespace collinea {

/// The weights of the equations of an absolute orientation: by  W = C_X + S C_u S'  with S = m R, point by point or of
/// all at once. Each point has three rows; those of what is not known of it count for nothing: zero, with the
/// variance 1.
class ControlWeights {
 public:
  /// Rows of a point: the seven parameters, then the misfit.
  using Rows = Eigen::Matrix<double, 3, 8, Eigen::RowMajor>;

  /// `full`: covariance of all model coordinates; nullptr: those of the points.
  ControlWeights(std::span<const AbsoluteControl> pairs, const Eigen::MatrixXd* full) : pairs_(pairs), full_(full) {}

  /// False when W is not positive definite.
  [[nodiscard]] bool set(const Eigen::Matrix3d& scaled_rotation);

  /// With W = L L': L^-1 of what belongs to the rows of all points, and L^-T.
  void whiten(std::vector<Rows>& rows) const;
  void whiten(std::vector<Eigen::Vector3d>& values) const;
  void whiten_transposed(std::vector<Rows>& rows) const;
  void whiten_transposed(std::vector<Eigen::Vector3d>& values) const;

  /// The diagonals of W^-1 and of W.
  struct Diagonals {
    std::vector<Eigen::Vector3d> inverse, covariance;
  };
  [[nodiscard]] Diagonals diagonals() const;

  /// Corrections of the model coordinates of all points by the multipliers W^-1 e.
  [[nodiscard]] std::vector<Eigen::Vector3d> model_corrections(const std::vector<Eigen::Vector3d>& multipliers) const;

 private:
  [[nodiscard]] bool set_full();

  std::span<const AbsoluteControl> pairs_;
  const Eigen::MatrixXd* full_;
  Eigen::Matrix3d scaled_rotation_ = Eigen::Matrix3d::Identity();
  std::vector<Eigen::Matrix3d> roots_;      // L^-1 of each point
  std::vector<Eigen::Vector3d> variances_;  // diagonals of W
  Eigen::LLT<Eigen::MatrixXd> whole_;
};

/// Sets to zero what is not known of the point.
void clear_unknown(const AbsoluteControl& pair, Eigen::Vector3d& on_axes);

}  // namespace collinea
