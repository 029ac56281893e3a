// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/internal/kept_factor.h"
#include "collinea/adjust/internal/step.h"
#include "collinea/adjust/point_normals.h"

namespace collinea::bundle {

inline constexpr double kExactDatum = 1e6;    ///< stiffness with which the constraints of the datum count as exact
inline constexpr double kLeastPivot = 1e-13;  ///< of its diagonal element: rounding leaves no more

/// The reduced normal equations of poses and cameras (points eliminated). Behind the cameras among the global
/// parameters, whose rows are full, come other unknowns and the points that measurements join to each other. Work is
/// cut into batches of points that stay in the cache; within a batch first every point, then every row of tiles is one
/// item, so that sums have one order whatever the number of threads.
class Normals {
 public:
  /// `kept`: may hold the factor of an earlier adjustment; outlives this.
  Normals(const Problem& problem, KeptFactor& kept);

  /// Linearises at `state` with damping `lambda` of every diagonal element; answers the cost. `datum_stiffness`: weight
  /// of the inner constraints, compared with what the images know of their rotations.
  double accumulate(const State& state, double lambda, const Run& run, double datum_stiffness = 1);
  /// Solves for poses and cameras. False when the matrix is not positive definite.
  [[nodiscard]] bool solve(const Run& run, Step& step);
  /// The diagonal that was damped.
  [[nodiscard]] const std::vector<double>& diagonal() const { return diagonal_; }
  /// The factor of the matrix; nothing when it is not positive definite, see TileCholesky::factor.
  [[nodiscard]] std::optional<TileCholesky> factor(const Run& run, double least_pivot, int& failed_row) {
    return kept_.take(matrix_, pattern_, run, least_pivot, failed_row);
  }

 private:
  struct Batch {
    std::size_t first_point, end_point;
    std::size_t first_row = 0, end_row = 0;  // in batch_rows_
  };
  struct BatchRow {  // the rays of a batch in the images of one tile row
    int tile_row;
    std::uint32_t first_ray, end_ray;  // in row_rays_
  };
  struct GlobalSums {  // of one chunk of points
    std::vector<double> matrix, right, diagonal;
    double cost = 0;
  };

  void cut_batches();
  void index_rows();
  void linearise_points(const State& state, double lambda, const Batch& batch, std::size_t chunk);
  void linearise_point(const State& state, double lambda, const Batch& batch, std::size_t point, GlobalSums& sums);
  void add_camera_ray(const LinearRay& linear, const ProblemCamera& camera, const double* b, double* wc,
                      GlobalSums& sums) const;
  void reduce_cameras(std::size_t point, const PointNormals& normals, const double* y, const Batch& batch,
                      GlobalSums& sums);
  void add_row(const Batch& batch, const BatchRow& row);
  void add_pose_ray(const Batch& batch, std::uint32_t ray, double* const* tile_of, std::vector<double*>& blocks);
  void add_pose_cameras(const Batch& batch, std::uint32_t ray);
  class Sink;
  template <class Kind>
  double add_kind(const State& state);
  double add_retained(const State& state);
  void add_observation(const Row& row, double weight, double residual);
  void add_to_globals(int row, int column, double value);
  void add_datum(double stiffness);
  void assemble(double lambda);

  const Problem& problem_;
  KeptFactor& kept_;
  TilePattern pattern_;
  TileMatrix matrix_;
  std::vector<double> right_, diagonal_;  // of poses and cameras
  std::vector<double> pose_camera_;       // 6 x border of each pose, by columns of 6
  std::vector<GlobalSums> chunks_;
  GlobalSums global_sums_;
  std::vector<Batch> batches_;
  std::vector<BatchRow> batch_rows_;
  std::vector<std::uint32_t> row_rays_;
  std::vector<std::uint32_t> first_of_ray_, point_of_ray_;
  std::vector<std::uint32_t> camera_begin_;  // of each point: the cameras its rays have, in cameras_of_point_
  std::vector<int> cameras_of_point_;
  // Buffers of the batch in work:
  std::vector<PoseRay> pose_rays_;
  std::vector<double> camera_rays_;    // 2 x P of each ray
  std::vector<double> camera_points_;  // Zc = Wc L^-T, P x 3 by rows, of each (point, camera)
  int widest_camera_ = 0;
};

}  // namespace collinea::bundle
