// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/free_network.h"

#include <Eigen/LU>
#include <map>

#include "collinea/adjust/gauge.h"
#include "collinea/adjust/point_cofactor.h"

namespace collinea::bundle {

Eigen::MatrixXd FreeNetwork::of_place(const Part& part, const Eigen::Vector3d& place) const {
  return part.size * motion_of(place, part.centre, part.size) * part.motions;
}

FreeNetwork::FreeNetwork(const Problem& problem, const State& state, const TileCholesky& factor)
    : problem_(problem), state_(state) {
  if (problem.datum.empty()) return;
  std::map<int, std::vector<const DatumConstraint*>> defects;
  for (const DatumConstraint& unseen : problem.datum) defects[unseen.part].push_back(&unseen);
  part_of_pose_.assign(static_cast<std::size_t>(problem.poses), -1);
  part_of_point_.assign(problem.point_count(), -1);
  for (const auto& [number, unseen] : defects) {
    const auto its = static_cast<int>(parts_.size());
    Part& part = parts_.emplace_back();
    part.centre = unseen.front()->centre;
    part.size = unseen.front()->size;
    part.motions.resize(7, static_cast<Eigen::Index>(unseen.size()));
    for (std::size_t k = 0; k < unseen.size(); ++k) part.motions.col(static_cast<Eigen::Index>(k)) = unseen[k]->motion;
    for (int pose = 0; pose < problem.poses; ++pose)
      if (problem.part_of_pose[static_cast<std::size_t>(pose)] == number)
        part_of_pose_[static_cast<std::size_t>(pose)] = its;
  }
  const auto rows = static_cast<Eigen::Index>(factor.tile_rows()) * kTile;
  for (Part& part : parts_) {
    part.with_motions.setZero(rows, part.motions.cols());
    part.inverse.setZero(part.motions.cols(), part.motions.cols());
    part.variance = part.inverse;
  }
  const auto each_point = [&](const auto& work) {
    for (std::size_t p = 0; p < problem.point_count(); ++p) {
      if (problem.point(p).held || problem.point(p).first_free == problem.end_ray(p)) continue;
      const int its = part_of_pose_[problem.rays[problem.point(p).first_free].image];
      if (its < 0 || problem.point(p).control >= 0) continue;
      part_of_point_[p] = its;
      Part& part = parts_[static_cast<std::size_t>(its)];
      const PointSystem system(problem, state, p);
      work(part, system, of_place(part, Eigen::Map<const Eigen::Vector3d>(&state.points[3 * p])));
    }
  };
  each_point([&](Part& part, const PointSystem& system, const Eigen::MatrixXd& g) {
    part.inverse += g.transpose() * g;
    for (Eigen::Index k = 0; k < g.cols(); ++k) {
      Eigen::VectorXd column = part.with_motions.col(k);
      system.add_following(g.col(k), column);
      part.with_motions.col(k) = column;
    }
  });
  for (Part& part : parts_) {
    part.inverse = part.inverse.inverse().eval();
    for (Eigen::Index k = 0; k < part.with_motions.cols(); ++k) factor.solve(part.with_motions.col(k).data());
  }
  each_point([&](Part& part, const PointSystem& system, const Eigen::MatrixXd& g) {
    for (Eigen::Index k = 0; k < g.cols(); ++k)
      part.variance.col(k) +=
          g.transpose() * (system.solve_own(g.col(k)) + system.follow(part.with_motions.col(k).data()));
  });
}

// C - G M H' - H M G' + G M T M G'.
void FreeNetwork::transform(const Part& part, const Eigen::MatrixXd& moved, const Eigen::MatrixXd& with_motions,
                            Eigen::Ref<Eigen::MatrixXd> covariance) {
  const Eigen::MatrixXd by = moved * part.inverse, mixed = by * with_motions.transpose();
  covariance += by * part.variance * by.transpose() - mixed - mixed.transpose();
}

Matrix6d FreeNetwork::of_pose(const Matrix6d& covariance, int pose, const Matrix6d& to_world) const {
  if (parts_.empty() || part_of_pose_[static_cast<std::size_t>(pose)] < 0) return covariance;
  const Part& part = parts_[static_cast<std::size_t>(part_of_pose_[static_cast<std::size_t>(pose)])];
  Eigen::MatrixXd moved(6, part.motions.cols());
  moved.topRows(3) = -part.motions.middleRows(3, 3);
  moved.bottomRows(3) =
      of_place(part, Eigen::Map<const Eigen::Vector3d>(state_.frames[static_cast<std::size_t>(pose)].data() + 9));
  Eigen::MatrixXd transformed = covariance;
  transform(part, moved, to_world * part.with_motions.middleRows(6 * pose, 6), transformed);
  return transformed;
}

Eigen::Matrix3d FreeNetwork::of_point(const Eigen::Matrix3d& covariance, std::size_t point) const {
  if (parts_.empty() || part_of_point_[point] < 0) return covariance;
  const Part& part = parts_[static_cast<std::size_t>(part_of_point_[point])];
  const PointSystem system(problem_, state_, point);
  const Eigen::MatrixXd moved = of_place(part, Eigen::Map<const Eigen::Vector3d>(&state_.points[3 * point]));
  Eigen::MatrixXd with_motions(3, moved.cols());
  for (Eigen::Index k = 0; k < moved.cols(); ++k)
    with_motions.col(k) = system.solve_own(moved.col(k)) + system.follow(part.with_motions.col(k).data());
  Eigen::MatrixXd transformed = covariance;
  transform(part, moved, with_motions, transformed);
  return transformed;
}

}  // namespace collinea::bundle
