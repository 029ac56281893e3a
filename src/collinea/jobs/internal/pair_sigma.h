// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "collinea/dense/epipolar_pair.h"
#include "collinea/jobs/internal/pair_control.h"

namespace collinea {

/// By how much each degree of freedom of changed() is moved to either side where derivatives by it are taken from
/// differences: its standard deviation, 1e-9 [rad, bases] at least.
[[nodiscard]] Vector5 difference_steps(const RelativeOrientation& orientation);

/// What relative and absolute orientation make uncertain of a point of a pair's surface. With x the change of the
/// relative orientation, of covariance C, and t the similarity to the ground, of covariance T for a given model,
///     covariance = B C B' + J T J',   B = dX/dx,   J = dX/dt.
/// A change of the relative orientation moves the point in the model and, by way of the control, which is intersected
/// in that model, the similarity: B holds both. It is taken from differences of one standard deviation to either side,
/// each with its own epipolar pair and absolute orientation. Without control the ground is the frame of the left
/// camera, and the base is exact.
class PairOrientationSigma {
 public:
  /// Errors: an orientation one standard deviation away cannot be made.
  static Result<PairOrientationSigma> of(const ModelOfPair& model, const std::optional<PairControl>& control,
                                         const std::optional<AbsoluteOrientation>& absolute);

  /// On the ground [m^2], linear between nodes of a lattice over the left epipolar image and the disparities of
  /// the points of the orientation and a fifth of their range beyond; farther away as there.
  [[nodiscard]] Eigen::Matrix3d covariance(const Eigen::Vector2d& left_px, double disparity_px) const;

  /// Of a pair whose exterior orientations are given, with their covariances, as independent of each other.
  static Result<PairOrientationSigma> of(const ModelOfPair& model, const std::array<UncertainPose, 2>& poses);

 private:
  struct Lattice {
    double step_x = 1, step_y = 1, low = 0, step_d = 1;
  };

  static Lattice lattice_of(const ModelOfPair& model);
  PairOrientationSigma(const Lattice& lattice, std::vector<Eigen::Matrix3d> nodes)
      : lattice_(lattice), nodes_(std::move(nodes)) {}

  Lattice lattice_;
  std::vector<Eigen::Matrix3d> nodes_;
};

}  // namespace collinea
