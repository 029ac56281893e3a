// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/kind_vertical.h"

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/internal/datum_parts.h"
#include "collinea/geometry/rotation.h"

namespace collinea::bundle {

double Vertical::add(const Problem& problem, const State& state, const Item& item, ObservationSink& sink) {
  const Eigen::Vector3d residual = whitened(problem, state, item);
  const Eigen::Matrix3d by_rotation =
      -item.inverse_sigma * skew(z_in_cam(state.frames[item.image]));  // of the computed direction
  const Eigen::Matrix3d square = by_rotation.transpose() * by_rotation;
  const Eigen::Vector3d right = by_rotation.transpose() * residual;
  const int first = 6 * static_cast<int>(item.image);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) sink.add_to_pose(first + r, first + c, square(r, c));
    sink.add_to_right(first + r, right[r]);
  }
  return residual.squaredNorm();
}

Eigen::Vector3d Vertical::predicted(const Problem& problem, const State& state, const State&,
                                    const std::vector<double>& reduced, const Item& item) {
  const Eigen::Vector3d up = z_in_cam(state.frames[item.image]), rotation(&reduced[6ul * item.image]);
  return whitened(problem, state, item) - item.inverse_sigma * rotation.cross(up);
}

void Vertical::add_to_gauge(const Problem& problem, const State& state, const BlockMotion& motion,
                            MotionNormals& normals) {
  for (const GivenUp& given : problem.verticals) {
    const Eigen::Matrix3d cam_from_world =
        (state.rotations[given.image] * motion.moved.rotation.conjugate()).toRotationMatrix();
    const Eigen::Vector3d residual = given.residual(cam_from_world.col(2));
    // A world turned by w sees its old z axis turned by -w.
    const Eigen::Matrix3d by_rotation = given.inverse_sigma * cam_from_world * skew(Eigen::Vector3d::UnitZ());
    normals.matrix.block<3, 3>(3, 3) += by_rotation.transpose() * by_rotation;
    normals.right.segment<3>(3) += by_rotation.transpose() * residual;
    normals.cost += residual.squaredNorm();
  }
}

void Vertical::observe_motions(const Problem& problem, const State&, std::vector<DatumPart>& parts) {
  for (const GivenUp& given : problem.verticals) {
    DatumPart& its = parts[problem.part_of_pose[given.image]];
    its.seen.diagonal().segment<2>(3).array() += 1;
    its.sources.attitudes = true;
  }
}

double Vertical::redundancy(const State& state, const Item& item, const Eigen::Matrix3d& cofactor) {
  const Eigen::Matrix3d by_rotation = item.inverse_sigma * skew(z_in_cam(state.frames[item.image]));
  return 2 - (by_rotation * cofactor * by_rotation.transpose()).trace();
}

}  // namespace collinea::bundle
