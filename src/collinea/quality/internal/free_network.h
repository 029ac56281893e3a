// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/base/run.h"
#include "collinea/math/tile_cholesky.h"
#include "collinea/quality/datum_points.h"
#include "collinea/quality/internal/point_cofactor.h"

namespace collinea {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

namespace bundle {

/// Takes covariances of a block that nothing fixes entirely from the few images that fixed its datum to that of all tie
/// points (S-transformation, Baarda 1973): of all minimal datums the one in which the trace of the points' covariance
/// is least. Nothing changes where there is no datum defect. A part whose tie points do not tell its motions (fewer
/// than three, or all on a line) takes its control points too; where that does not help either, it stays in the datum
/// of the images.
class FreeNetwork {
 public:
  /// At most seven solutions for each unconnected part. `chosen`: the points of the datum in the place of all tie
  /// points; a part whose motions these do not tell stays in the datum of the images.
  FreeNetwork(const Solved& solved, const TileCholesky& factor, DatumPoints chosen = {}, const Run& run = {});

  /// Every part that something leaves free has the datum of points: of those chosen, or of its own.
  [[nodiscard]] bool has_datum_of_points() const { return parts_without_ == 0; }

  /// Covariance of [rotation in the world, centre]; `to_world` turns the internal rotation there.
  [[nodiscard]] Matrix6d of_pose(const Matrix6d& covariance, int pose, const Matrix6d& to_world) const;
  /// Covariance of one of the global parameters that no motion of the whole changes (of a camera), `row` of the reduced
  /// unknowns, with [rotation in the world, centre]. Its own variance is the same in every datum.
  [[nodiscard]] Vector6d with_pose(const Vector6d& covariance, int row, int pose) const;
  /// Covariance of a tie point or a control point, of which the system is.
  [[nodiscard]] Eigen::Matrix3d of_point(const Eigen::Matrix3d& covariance, const PointSystem& system,
                                         std::size_t point) const;
  /// Covariance of a point that takes no part, by its rays in these poses (-1: an exact image).
  [[nodiscard]] Eigen::Matrix3d of_check_point(const Eigen::Matrix3d& covariance, const PointSystem& system,
                                               const Eigen::Vector3d& position, const std::vector<int>& poses) const;
  /// Variance of a measurement on the ground.
  [[nodiscard]] double of_link(double variance, const GeodeticLink& link, const GeodeticModel& model,
                               const Row& row) const;

 private:
  struct Part {
    int number = 0;           // in Problem::part_of_pose
    Eigen::MatrixXd motions;  // 7 x k: what nothing observes
    Eigen::Vector3d centre;
    double size = 1;
    bool by_control = false;       // the datum is that of its control points, too
    Eigen::MatrixXd with_motions;  // covariance of the reduced unknowns with the motion of the points, x k
    Eigen::MatrixXd inverse;       // of the points' motions, k x k
    Eigen::MatrixXd variance;      // of the motion of the points
  };
  [[nodiscard]] Eigen::MatrixXd of_position(const Part& part, const Eigen::Vector3d& position) const;
  [[nodiscard]] Eigen::MatrixXd of_image(const Part& part, int pose) const;
  [[nodiscard]] Eigen::Vector3d position_of(std::size_t point) const;
  [[nodiscard]] const Part* part_numbered(int number) const;
  [[nodiscard]] const Part* part_of(int pose) const;
  [[nodiscard]] const Part* part_with(std::size_t point) const;
  [[nodiscard]] bool in_datum(const Part& part, std::size_t point) const;
  [[nodiscard]] bool find_inverse(Part& part) const;
  void add_points(Part& part, const TileCholesky& factor, const Run& run);
  [[nodiscard]] Eigen::MatrixXd with_motions(const Part& part, std::size_t point, const PointSystem& system) const;
  static void transform(const Part& part, const Eigen::MatrixXd& moved, const Eigen::MatrixXd& with_motions,
                        Eigen::Ref<Eigen::MatrixXd> covariance);

  const Problem& problem_;
  const State& state_;
  DatumPoints chosen_;
  std::vector<Part> parts_;
  std::size_t parts_without_ = 0;
};

}  // namespace bundle
}  // namespace collinea
