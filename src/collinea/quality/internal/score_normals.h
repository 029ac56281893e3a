// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "collinea/adjust/point_normals.h"
#include "collinea/adjust/solved.h"
#include "collinea/base/run.h"
#include "collinea/math/tile_cholesky.h"
#include "collinea/quality/internal/hypothesis.h"

namespace collinea::bundle {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Derivatives of an image point [px] by the columns of hypotheses (2 x columns) and by the unknowns of the adjustment.
struct RayDerivatives {
  int image = 0, camera = 0;  ///< index in Problem::images, Problem::cameras
  Eigen::MatrixXd by_column;
  Eigen::MatrixXd by_camera;  ///< by ProblemCamera::free
  Eigen::Matrix<double, 2, 3> by_rotation, by_point;
};

/// The normal equations of all hypotheses beside those of the adjustment. With the columns H of all hypotheses and the
/// residuals v, the last of them, together M = (H v):
///
///     gram = M' P M - M' P A (A' P A)^-1 A' P M
///
/// by one pass over the rays, in which every point is eliminated as in the adjustment (Normals), and one solution with
/// its factor for each column. P has the weights of the robust losses, as covariances have. The last column of gram is
/// H' P v without what a step of the adjustment that was left out would change: iterations need not have gone to the
/// end.
class ScoreNormals {
 public:
  ScoreNormals(const Solved& solved, const HypothesisColumns& columns, const TileCholesky& factor, const Run& run);

  [[nodiscard]] const Eigen::MatrixXd& gram() const { return gram_; }
  /// M' P M alone.
  [[nodiscard]] const Eigen::MatrixXd& before_reduction() const { return before_; }
  /// Parts of gram that positions and other observations in metres or radians have, by the residuals of M after the
  /// adjustment: M - A (A' P A)^-1 A' P M.
  [[nodiscard]] const Eigen::MatrixXd& of_positions() const { return of_positions_; }
  [[nodiscard]] const Eigen::MatrixXd& of_others() const { return of_others_; }
  /// (A' P A)^-1 A' P M in the reduced unknowns.
  [[nodiscard]] const Eigen::MatrixXd& solution() const { return solution_; }
  /// A' P M of one point in its own unknowns, 3 x columns; and its rays.
  [[nodiscard]] Eigen::MatrixXd point_columns(std::size_t point, std::vector<RayDerivatives>* rays = nullptr) const;

 private:
  struct Chunk;
  struct Segment {
    int first, count;
  };
  struct RayColumns;

  void add_points(Chunk& chunk, std::size_t first, std::size_t end) const;
  void add_point(Chunk& chunk, std::size_t point) const;
  bool take_ray(const Ray& ray, const double* position, const Loss& loss, RayColumns& out) const;
  void add_ray(Chunk& chunk, const RayColumns& ray, int image) const;
  static void add_shape(Chunk& chunk, const RayColumns& ray);
  void eliminate(Chunk& chunk, PointNormals normals) const;
  void add_control(Chunk& chunk, std::size_t point, PointNormals& normals) const;
  void add_given();
  template <class Kind>
  void add_given_kind();
  void solve(const TileCholesky& factor, const Run& run);
  void split_groups();
  void add_control_residuals();

  const Problem& problem_;
  const State& state_;
  const HypothesisColumns& columns_;
  int first_, width_;  // of the columns of images
  RowMajorMatrix right_;
  Eigen::MatrixXd gram_, before_, solution_, of_positions_, of_others_;
};

}  // namespace collinea::bundle
