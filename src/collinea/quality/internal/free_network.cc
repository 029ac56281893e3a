// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/free_network.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <utility>

#include "collinea/adjust/block_motion.h"
#include "collinea/base/parallel.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kAtOnce = 4096;  // points

}  // namespace

Eigen::MatrixXd FreeNetwork::of_position(const Part& part, const Eigen::Vector3d& position) const {
  return part.size * motion_of(position, part.centre, part.size) * part.motions;
}

// Of [rotation in the world, centre].
Eigen::MatrixXd FreeNetwork::of_image(const Part& part, int pose) const {
  Eigen::MatrixXd moved(6, part.motions.cols());
  moved.topRows(3) = -part.motions.middleRows(3, 3);
  moved.bottomRows(3) = of_position(part, centre_in(state_, static_cast<std::size_t>(pose)));
  return moved;
}

Eigen::Vector3d FreeNetwork::position_of(std::size_t point) const {
  return Eigen::Map<const Eigen::Vector3d>(&state_.points[3 * point]);
}

// Nothing for parts that are fixed.
const FreeNetwork::Part* FreeNetwork::part_numbered(int number) const {
  for (const Part& part : parts_)
    if (part.number == number) return &part;
  return nullptr;
}

const FreeNetwork::Part* FreeNetwork::part_of(int pose) const {
  return pose < 0 ? nullptr : part_numbered(problem_.part_of_pose[static_cast<std::size_t>(pose)]);
}

const FreeNetwork::Part* FreeNetwork::part_with(std::size_t point) const {
  return problem_.point(point).is_fixed ? nullptr : part_numbered(problem_.part_of_point[point]);
}

// What no image shows moves with the part, but is nothing of what the images determine.
bool FreeNetwork::in_datum(const Part& part, std::size_t point) const {
  if (part_with(point) != &part) return false;
  const ProblemPoint& its = problem_.point(point);
  if (!chosen_.empty())
    return its.first_free < problem_.end_ray(point) &&
           (its.control < 0 ? chosen_.ties.contains(PointId{its.id}) : chosen_.control.contains(ControlId{its.id}));
  return its.control < 0 || (part.by_control && its.first_free < problem_.end_ray(point));
}

// False when the points do not tell all motions.
bool FreeNetwork::find_inverse(Part& part) const {
  const Eigen::Index count = part.motions.cols();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
  for (std::size_t p = 0; p < problem_.point_count(); ++p)
    if (in_datum(part, p)) {
      const Eigen::MatrixXd g = of_position(part, position_of(p));
      sum += g.transpose() * g;
    }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(sum);
  if (!(eigen.eigenvalues()[0] > kSeenMotion * eigen.eigenvalues()[count - 1])) return false;
  part.inverse =
      eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose();
  return true;
}

FreeNetwork::FreeNetwork(const Solved& solved, const TileCholesky& factor, DatumPoints chosen, const Run& run)
    : problem_(solved.problem()), state_(solved.state()), chosen_(std::move(chosen)) {
  std::map<int, std::vector<const DatumConstraint*>> defects;
  for (const DatumConstraint& unseen : problem_.datum) defects[unseen.part].push_back(&unseen);
  for (const auto& [number, unseen] : defects) {
    Part& part = parts_.emplace_back();
    part.number = number;
    part.centre = unseen.front()->centre;
    part.size = unseen.front()->size;
    part.motions.resize(7, static_cast<Eigen::Index>(unseen.size()));
    for (std::size_t k = 0; k < unseen.size(); ++k) part.motions.col(static_cast<Eigen::Index>(k)) = unseen[k]->motion;
  }
  std::vector<int> without;
  for (Part& part : parts_) {
    if (find_inverse(part)) continue;
    part.by_control = true;
    if (!find_inverse(part)) without.push_back(part.number);
  }
  std::erase_if(parts_, [&](const Part& part) {
    return std::find(without.begin(), without.end(), part.number) != without.end();
  });
  parts_without_ = without.size();
  for (Part& part : parts_) add_points(part, factor, run);
}

// What the points of the datum do together.
void FreeNetwork::add_points(Part& part, const TileCholesky& factor, const Run& run) {
  const Eigen::Index count = part.motions.cols();
  part.with_motions.setZero(static_cast<Eigen::Index>(factor.tile_rows()) * kTile, count);
  part.variance.setZero(count, count);
  for (std::size_t p = 0; p < problem_.point_count(); ++p) {
    if (!in_datum(part, p)) continue;
    const Eigen::MatrixXd g = of_position(part, position_of(p));
    if (const int first_retained = problem_.point(p).first_retained; first_retained >= 0) {
      part.with_motions.middleRows<3>(6 * problem_.poses + first_retained) += g;
      continue;
    }
    const PointSystem system(problem_, state_, p);
    for (Eigen::Index k = 0; k < count; ++k) system.add_following(g.col(k), part.with_motions.col(k));
  }
  for (Eigen::Index k = 0; k < count; ++k) factor.solve(part.with_motions.col(k).data());
  std::vector<Eigen::MatrixXd> variances(std::min(kAtOnce, problem_.point_count()));
  for (std::size_t first = 0; first < problem_.point_count(); first += kAtOnce) {
    const std::size_t some = std::min(kAtOnce, problem_.point_count() - first);
    parallel_for(run, some, [&](std::size_t i) {
      const std::size_t p = first + i;
      if (in_datum(part, p))
        variances[i] =
            of_position(part, position_of(p)).transpose() * with_motions(part, p, PointSystem(problem_, state_, p));
    });
    if (run.stopped()) return;
    for (std::size_t i = 0; i < some; ++i)
      if (in_datum(part, first + i)) part.variance += variances[i];
  }
}

// The covariance of a point with the motion of the points.
Eigen::MatrixXd FreeNetwork::with_motions(const Part& part, std::size_t p, const PointSystem& system) const {
  if (const int first_retained = problem_.point(p).first_retained; first_retained >= 0)
    return part.with_motions.middleRows<3>(6 * problem_.poses + first_retained);
  Eigen::MatrixXd with(3, part.motions.cols());
  for (Eigen::Index k = 0; k < with.cols(); ++k) with.col(k) = system.follow(part.with_motions.col(k).data());
  if (in_datum(part, p)) {
    const Eigen::MatrixXd moved = of_position(part, position_of(p));
    for (Eigen::Index k = 0; k < with.cols(); ++k) with.col(k) += system.solve_own(moved.col(k));
  }
  return with;
}

// C - G M H' - H M G' + G M T M G'.
void FreeNetwork::transform(const Part& part, const Eigen::MatrixXd& moved, const Eigen::MatrixXd& with_motions,
                            Eigen::Ref<Eigen::MatrixXd> covariance) {
  const Eigen::MatrixXd by = moved * part.inverse, mixed = by * with_motions.transpose();
  covariance += by * part.variance * by.transpose() - mixed - mixed.transpose();
}

Matrix6d FreeNetwork::of_pose(const Matrix6d& covariance, int pose, const Matrix6d& to_world) const {
  const Part* part = part_of(pose);
  if (!part) return covariance;
  Eigen::MatrixXd transformed = covariance;
  transform(*part, of_image(*part, pose), to_world * part->with_motions.middleRows(6 * pose, 6), transformed);
  return transformed;
}

// C - H M G': what moves the whole leaves the parameter as it is.
Vector6d FreeNetwork::with_pose(const Vector6d& covariance, int row, int pose) const {
  const Part* part = part_of(pose);
  if (!part) return covariance;
  return covariance - of_image(*part, pose) * (part->inverse * part->with_motions.row(row).transpose());
}

Eigen::Matrix3d FreeNetwork::of_point(const Eigen::Matrix3d& covariance, const PointSystem& system,
                                      std::size_t point) const {
  const Part* part = part_with(point);
  if (!part) return covariance;
  Eigen::MatrixXd transformed = covariance;
  transform(*part, of_position(*part, position_of(point)), with_motions(*part, point, system), transformed);
  return transformed;
}

Eigen::Matrix3d FreeNetwork::of_check_point(const Eigen::Matrix3d& covariance, const PointSystem& system,
                                            const Eigen::Vector3d& position, const std::vector<int>& poses) const {
  const Part* part = poses.empty() ? nullptr : part_of(poses.front());
  for (const int pose : poses)
    if (!part || part_of(pose) != part) return covariance;  // it moves with none of them
  if (!part) return covariance;
  Eigen::MatrixXd with(3, part->motions.cols()), transformed = covariance;
  for (Eigen::Index k = 0; k < with.cols(); ++k) with.col(k) = system.follow(part->with_motions.col(k).data());
  transform(*part, of_position(*part, position), with, transformed);
  return transformed;
}

// The orientation of a set-up follows a turn about the plumb line, so that its directions stay; planes and lines follow
// every motion.
double FreeNetwork::of_link(double variance, const GeodeticLink& link, const GeodeticModel& model,
                            const Row& row) const {
  const Part* part = link.auxiliary >= 0 ? nullptr : part_with(link.from);
  if (!part || part_with(link.to) != part) return variance;
  const Eigen::MatrixXd moved = model.by_from.transpose() * of_position(*part, position_of(link.from)) +
                                model.by_to.transpose() * of_position(*part, position_of(link.to));
  Eigen::MatrixXd with = Eigen::MatrixXd::Zero(1, part->motions.cols()), transformed(1, 1);
  for (const RowPart& one : row) with += one.derivative * part->with_motions.row(one.row);
  transformed(0, 0) = variance;
  transform(*part, moved, with, transformed);
  return transformed(0, 0);
}

}  // namespace collinea::bundle
