// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/kind_attitude.h"

#include <algorithm>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/internal/datum_parts.h"
#include "collinea/geometry/rotation.h"

namespace collinea::bundle {
namespace {

// rotation_by(b + d) = rotation_by(J d) rotation_by(b), to the second order of b: 1e-6 at ten degrees.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& b) {
  const Eigen::Matrix3d cross = skew(b);
  return Eigen::Matrix3d::Identity() + cross / 2 + cross * cross / 6 + cross * cross * cross / 24;
}

// Given minus adjusted in the camera.
Eigen::Vector3d rotation_in_cam(const State& state, const GivenRotation& given) {
  Eigen::Quaterniond rotation = given.cam_from_world * state.rotations[given.image].conjugate();
  if (given.boresight >= 0) rotation = rotation_by(auxiliary3(state, given.boresight)) * rotation;
  return rotation_vector(rotation);
}

}  // namespace

Eigen::Vector3d residual_of(const State& state, const GivenRotation& given) {
  return rotation_in(state, given.image).transpose() * rotation_in_cam(state, given);
}

// The residual turns with the frame it is seen in: -(1 - [v]x / 2) e in the camera, to the first order of v.
Row row_of(const Problem& problem, const State& state, const GivenRotation& given, int axis) {
  const Eigen::Matrix3d by_rotation = rotation_in(state, given.image).transpose() *
                                      (Eigen::Matrix3d::Identity() - skew(rotation_in_cam(state, given)) / 2);
  Row row;
  for (int c = 0; c < 3; ++c) row.push_back({6 * static_cast<int>(given.image) + c, by_rotation(axis, c)});
  if (given.boresight >= 0)
    add_auxiliaries(problem, given.boresight,
                    -(by_rotation * left_jacobian(auxiliary3(state, given.boresight))).row(axis), row);
  return row;
}

Eigen::Vector3d Attitude::residual(const Problem&, const State& state, const Item& item) {
  return residual_of(state, item);
}

Row Attitude::row(const Problem& problem, const State& state, const Item& item, int axis) {
  return row_of(problem, state, item, axis);
}

Eigen::Vector3d Attitude::predicted(const Problem& problem, const State& state, const State&,
                                    const std::vector<double>& reduced, const Item& item) {
  Eigen::Vector3d left = residual_of(state, item);
  left -= change(problem, state, reduced, item);
  return left.cwiseProduct(item.inverse_sigma);
}

void Attitude::observe_rows(const Problem& problem, const State& state, std::vector<DatumPart>& parts,
                            MotionsWithAuxiliaries& rows) {
  for (const GivenRotation& given : problem.attitudes) {
    const int part = problem.part_of_pose[given.image];
    for (int axis = 0; axis < 3; ++axis)  // a world turned by w turns cam_from_world by -w in the world
      if (given.inverse_sigma[axis] > 0) rows.add(part, -Row7::Unit(3 + axis), row_of(problem, state, given, axis));
    parts[part].sources.attitudes |= given.inverse_sigma.maxCoeff() > 0;
  }
}

void Attitude::tabulate(const Problem& problem, const State& state, Adjusted& adjusted) {
  for (const GivenRotation& given : problem.attitudes)
    adjusted.attitudes.push_back({problem.images[given.image].id, -residual_of(state, given)});
  std::sort(adjusted.attitudes.begin(), adjusted.attitudes.end(), [](auto& a, auto& b) { return a.image < b.image; });
}

}  // namespace collinea::bundle
