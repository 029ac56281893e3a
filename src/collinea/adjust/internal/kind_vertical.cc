// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/kind_vertical.h"

#include "collinea/geometry/rotation.h"

namespace collinea::bundle {

double Vertical::add(const Problem& problem, const State& state, const Item& item, ObservationSink& sink) {
  const Eigen::Vector3d residual = whitened(problem, state, item);
  const Eigen::Matrix3d by_turn =
      -item.inverse_sigma * skew(z_in_cam(state.frames[item.image]));  // of the computed direction
  const Eigen::Matrix3d square = by_turn.transpose() * by_turn;
  const Eigen::Vector3d right = by_turn.transpose() * residual;
  const int first = 6 * static_cast<int>(item.image);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c <= r; ++c) sink.add_to_pose(first + r, first + c, square(r, c));
    sink.add_to_right(first + r, right[r]);
  }
  return residual.squaredNorm();
}

Eigen::Vector3d Vertical::predicted(const Problem& problem, const State& state, const State&,
                                    const std::vector<double>& reduced, const Item& item) {
  const Eigen::Vector3d up = z_in_cam(state.frames[item.image]), turn(&reduced[6ul * item.image]);
  return whitened(problem, state, item) - item.inverse_sigma * turn.cross(up);
}

double Vertical::redundancy(const State& state, const Item& item, const Eigen::Matrix3d& cofactor) {
  const Eigen::Matrix3d by_turn = item.inverse_sigma * skew(z_in_cam(state.frames[item.image]));
  return 2 - (by_turn * cofactor * by_turn.transpose()).trace();
}

}  // namespace collinea::bundle
