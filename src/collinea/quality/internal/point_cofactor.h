// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/adjust/point_normals.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea::bundle {

/// The linear equations of one point: its own normal matrix V = L L' and how it hangs on the reduced unknowns (poses
/// and cameras), Z = W L^-T. From these and the inverse Q of the reduced normal equations follow the cofactors of the
/// point and of everything computed from it. Add the rays, then close(); then ask.
class PointSystem {
 public:
  explicit PointSystem(const Problem& problem) : problem_(problem) {}
  /// The point with all its rays and, for control, its coordinates; closed.
  PointSystem(const Problem& problem, const State& state, std::size_t point);

  /// A ray in an image of the problem, or (image < 0) in one whose pose and camera are exact.
  void add(const LinearRay& linear, int image, const State& state);
  /// After the last ray. Fixed points have no unknowns of their own; those that keep theirs have them from row
  /// `first_retained` of the global parameters on (-1: the point is eliminated).
  void close(bool is_fixed, const ControlCoordinates* control, const double* position, int first_retained = -1);

  /// V^-1 b, V being the point's own normal matrix.
  [[nodiscard]] Eigen::Vector3d solve_own(Eigen::Vector3d b) const;
  /// How the point follows the reduced unknowns: -L^-T Z' x.
  [[nodiscard]] Eigen::Vector3d follow(const double* reduced) const;
  /// Covariance of the point, by the selected inverse: L^-T (I + Z' Q Z) L^-1.
  [[nodiscard]] Eigen::Matrix3d covariance(TileCholesky& inverse) const;
  /// The same by three solutions with the Cholesky factor: for points whose images share no tile of the inverse.
  [[nodiscard]] Eigen::Matrix3d covariance_by_solving(const TileCholesky& factor) const;
  /// Cofactors of the adjusted measurement of every ray in the order they were added, in units of its weight: the
  /// diagonal blocks of the hat matrix, A N^-1 A' P.
  [[nodiscard]] std::vector<Eigen::Matrix2d> leverages(TileCholesky& inverse) const;
  /// Adds to `by_reduced` how the point follows the reduced unknowns along a direction: -direction' L^-T Z'.
  void add_following(const Eigen::Vector3d& direction, Eigen::Ref<Eigen::VectorXd> by_reduced) const;
  /// The point's position relative to a pose of its rays along a direction: its variance, and its product with `vector`
  /// (of all reduced unknowns).
  struct Relative {
    double variance = 0, product = 0;
  };
  [[nodiscard]] Relative relative_to(int pose, const Eigen::Vector3d& direction, TileCholesky& inverse,
                                     const double* vector) const;
  /// False when the rays and coordinates do not fix the point.
  [[nodiscard]] bool determined() const;

 private:
  using Design = Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, Camera::kAllParams>;
  struct Group {  // of reduced unknowns: a pose or the free parameters of a camera
    int row, count, first;
    bool is_pose;
  };
  struct Measured {
    Eigen::Matrix<double, 2, 3> by_point;
    int pose = -1, camera = -1;  // numbers of groups
    Eigen::Matrix<double, 2, 6> by_pose;
    Design by_camera;
  };

  int group(int row, int count, bool is_pose);
  [[nodiscard]] Eigen::MatrixXd local(TileCholesky& inverse) const;
  [[nodiscard]] Eigen::Matrix3d with_own(const Eigen::Matrix3d& quadratic) const;

  const Problem& problem_;
  PointNormals normals_;
  std::vector<Group> groups_;
  std::vector<Measured> rays_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> z_;
  int width_ = 0;
  bool eliminated_ = true;
  int retained_group_ = -1;  // number of the group
};

}  // namespace collinea::bundle
