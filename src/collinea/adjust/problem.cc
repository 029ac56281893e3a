// SPDX-License-Identifier: Apache-2.0
// Observations by unknowns beside poses, cameras and points, and by points that are joined.
#include "collinea/adjust/problem.h"
#include "collinea/geometry/rotation.h"

namespace collinea::bundle {
namespace {

Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation_in(const State& state, std::uint32_t image) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(state.frames[image].data());
}

Eigen::Vector3d extra3(const State& state, int first) {
  return Eigen::Map<const Eigen::Vector3d>(&state.extras[static_cast<std::size_t>(first)]);
}

Eigen::Vector3d arm_of(const State& state, const GivenPosition& position) {
  return position.lever_arm < 0 ? position.arm : extra3(state, position.lever_arm);
}

// By unknowns of Problem::extras, three of them.
void add_extra(const Problem& problem, int first, const Eigen::RowVector3d& derivative, Row& row) {
  for (int c = 0; c < 3; ++c) row.push_back({6 * problem.poses + problem.first_extra + first + c, derivative[c]});
}

// rotation_by(b + d) = rotation_by(J d) rotation_by(b), to the second order of b: 1e-6 at ten degrees.
Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& b) {
  const Eigen::Matrix3d cross = skew(b);
  return Eigen::Matrix3d::Identity() + cross / 2 + cross * cross / 6 + cross * cross * cross / 24;
}

// Given minus adjusted in the camera.
Eigen::Vector3d turn_in_cam(const State& state, const GivenTurn& given) {
  Eigen::Quaterniond turn = given.cam_from_world * state.rotations[given.image].conjugate();
  if (given.boresight >= 0) turn = rotation_by(extra3(state, given.boresight)) * turn;
  return rotation_vector(turn);
}

}  // namespace

Frame frame_of(const Eigen::Quaterniond& rotation, const double* centre) {
  const Eigen::Matrix3d r = rotation.toRotationMatrix();
  return {r(0, 0), r(0, 1), r(0, 2), r(1, 0),   r(1, 1),   r(1, 2),
          r(2, 0), r(2, 1), r(2, 2), centre[0], centre[1], centre[2]};
}

GroundModel model_of(const Problem& problem, const GroundLink& link, const State& state) {
  const Eigen::Vector3d from(&state.points[3ul * link.from]);
  const double* extra = link.extra < 0 ? nullptr : &state.extras[static_cast<std::size_t>(link.extra)];
  if (link.shape >= 0)
    return shape_model(link.observation, problem.shapes[static_cast<std::size_t>(link.shape)], extra, from,
                       problem.level_at_origin);
  return ground_model(link.observation, from, Eigen::Vector3d(&state.points[3ul * link.to]), extra ? *extra : 0,
                      problem.level_at_origin);
}

Row row_of(const Problem& problem, const GroundLink& link, const GroundModel& model) {
  const int border = 6 * problem.poses;
  Row row;
  const auto add_point = [&](std::uint32_t number, const Eigen::Vector3d& derivative) {
    const int joined = problem.point(number).joined;
    for (int c = 0; c < 3 && joined >= 0; ++c)  // held points have no unknowns
      row.push_back({border + joined + c, derivative[c]});
  };
  add_point(link.from, model.by_from);
  if (link.to != link.from) add_point(link.to, model.by_to);
  for (int k = 0; k < model.extras; ++k)
    row.push_back({border + problem.first_extra + link.extra + k, model.by_extra[static_cast<std::size_t>(k)]});
  return row;
}

Eigen::Vector3d antenna_of(const State& state, const GivenPosition& position) {
  Eigen::Vector3d antenna(state.frames[position.image].data() + 9);
  if (position.plain()) return antenna;
  antenna += rotation_in(state, position.image).transpose() * arm_of(state, position);
  if (position.shift >= 0) antenna += extra3(state, position.shift);
  if (position.drift >= 0) antenna += position.time * extra3(state, position.drift);
  if (position.time_offset >= 0)
    antenna += state.extras[static_cast<std::size_t>(position.time_offset)] * position.velocity;
  return antenna;
}

Row row_of(const Problem& problem, const State& state, const GivenPosition& position, int axis) {
  const Eigen::Matrix3d world_from_cam = rotation_in(state, position.image).transpose();
  const Eigen::RowVector3d by_turn = (world_from_cam * skew(arm_of(state, position))).row(axis);
  const int first = 6 * static_cast<int>(position.image);
  Row row;
  for (int c = 0; c < 3; ++c) row.push_back({first + c, by_turn[c]});
  row.push_back({first + 3 + axis, 1});
  if (position.lever_arm >= 0) add_extra(problem, position.lever_arm, world_from_cam.row(axis), row);
  const Eigen::RowVector3d unit = Eigen::RowVector3d::Unit(axis);
  if (position.shift >= 0) add_extra(problem, position.shift, unit, row);
  if (position.drift >= 0) add_extra(problem, position.drift, position.time * unit, row);
  if (position.time_offset >= 0)
    row.push_back({6 * problem.poses + problem.first_extra + position.time_offset, position.velocity[axis]});
  return row;
}

Eigen::Vector3d residual_of(const State& state, const GivenTurn& given) {
  return rotation_in(state, given.image).transpose() * turn_in_cam(state, given);
}

// The residual turns with the frame it is seen in: -(1 - [v]x / 2) e in the camera, to the first order of v.
Row row_of(const Problem& problem, const State& state, const GivenTurn& given, int axis) {
  const Eigen::Matrix3d by_turn =
      rotation_in(state, given.image).transpose() * (Eigen::Matrix3d::Identity() - skew(turn_in_cam(state, given)) / 2);
  Row row;
  for (int c = 0; c < 3; ++c) row.push_back({6 * static_cast<int>(given.image) + c, by_turn(axis, c)});
  if (given.boresight >= 0)
    add_extra(problem, given.boresight, -(by_turn * left_jacobian(extra3(state, given.boresight))).row(axis), row);
  return row;
}

}  // namespace collinea::bundle
