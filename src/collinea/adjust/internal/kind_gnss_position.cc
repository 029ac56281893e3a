// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/kind_gnss_position.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/internal/datum_parts.h"
#include "collinea/geometry/rotation.h"

namespace collinea::bundle {
namespace {

Eigen::Vector3d arm_of(const State& state, const GivenPosition& position) {
  return position.lever_arm < 0 ? position.arm : auxiliary3(state, position.lever_arm);
}

}  // namespace

Eigen::Vector3d antenna_of(const State& state, const GivenPosition& position) {
  Eigen::Vector3d antenna(state.frames[position.image].data() + 9);
  if (position.plain()) return antenna;
  antenna += rotation_in(state, position.image).transpose() * arm_of(state, position);
  if (position.shift >= 0) antenna += auxiliary3(state, position.shift);
  if (position.drift >= 0) antenna += position.time * auxiliary3(state, position.drift);
  if (position.time_offset >= 0)
    antenna += state.auxiliaries[static_cast<std::size_t>(position.time_offset)] * position.velocity;
  return antenna;
}

Row row_of(const Problem& problem, const State& state, const GivenPosition& position, int axis) {
  const Eigen::Matrix3d world_from_cam = rotation_in(state, position.image).transpose();
  const Eigen::RowVector3d by_rotation = (world_from_cam * skew(arm_of(state, position))).row(axis);
  const int first = 6 * static_cast<int>(position.image);
  Row row;
  for (int c = 0; c < 3; ++c) row.push_back({first + c, by_rotation[c]});
  row.push_back({first + 3 + axis, 1});
  if (position.lever_arm >= 0) add_auxiliaries(problem, position.lever_arm, world_from_cam.row(axis), row);
  const Eigen::RowVector3d unit = Eigen::RowVector3d::Unit(axis);
  if (position.shift >= 0) add_auxiliaries(problem, position.shift, unit, row);
  if (position.drift >= 0) add_auxiliaries(problem, position.drift, position.time * unit, row);
  if (position.time_offset >= 0)
    row.push_back({6 * problem.poses + problem.first_auxiliary + position.time_offset, position.velocity[axis]});
  return row;
}

Eigen::Vector3d GnssPosition::residual(const Problem&, const State& state, const Item& item) {
  return item.given - antenna_of(state, item);
}

Row GnssPosition::row(const Problem& problem, const State& state, const Item& item, int axis) {
  if (item.plain()) return {{6 * static_cast<int>(item.image) + 3 + axis, 1}};
  return row_of(problem, state, item, axis);
}

double GnssPosition::add(const Problem& problem, const State& state, const Item& item, ObservationSink& sink) {
  if (!item.plain()) return ObservationKind::add(problem, state, item, sink);
  const Eigen::Vector3d residual = whitened(problem, state, item);
  const double s = residual.squaredNorm(), weight = problem.position_loss.weight(s);
  for (int c = 0; c < 3; ++c) {
    const int row = 6 * static_cast<int>(item.image) + 3 + c;
    const double w = item.inverse_sigma[c];
    sink.add_to_pose(row, row, weight * w * w);
    sink.add_to_right(row, weight * w * residual[c]);
  }
  return problem.position_loss.cost(s);
}

bool GnssPosition::is_gauge_complete(const Problem& problem) {
  return std::all_of(problem.positions.begin(), problem.positions.end(), [](const Item& one) { return one.plain(); });
}

void GnssPosition::add_to_gauge(const Problem& problem, const State& state, const BlockMotion& motion,
                                MotionNormals& normals) {
  for (const GivenPosition& position : problem.positions) {
    const Eigen::Vector3d centre = centre_in(state, position.image);
    const Eigen::Vector3d given =
        position.plain() ? position.given : position.given - (antenna_of(state, position) - centre);
    normals.add_position(motion, centre, given, position.inverse_sigma.cwiseAbs2().asDiagonal(), problem.position_loss);
  }
}

void GnssPosition::observe_motions(const Problem& problem, const State& state, std::vector<DatumPart>& parts) {
  for (const GivenPosition& position : problem.positions) {
    if (!position.plain()) continue;
    DatumPart& its = parts[problem.part_of_pose[position.image]];
    its.add(centre_in(state, position.image), (position.inverse_sigma.array() > 0).cast<double>());
    its.sources.positions = true;
  }
}

void GnssPosition::observe_rows(const Problem& problem, const State& state, std::vector<DatumPart>& parts,
                                MotionsWithAuxiliaries& rows) {
  for (const GivenPosition& position : problem.positions) {
    if (position.plain()) continue;
    const int part = problem.part_of_pose[position.image];
    DatumPart& its = parts[part];
    const Matrix37 motions = motion_of(centre_in(state, position.image), its.centre, its.size);
    for (int axis = 0; axis < 3; ++axis)
      if (position.inverse_sigma[axis] > 0) rows.add(part, motions.row(axis), row_of(problem, state, position, axis));
    its.sources.positions = true;
  }
}

void GnssPosition::tabulate(const Problem& problem, const State& state, Adjusted& adjusted) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const GivenPosition& position : problem.positions) {
    Eigen::Vector3d difference = antenna_of(state, position) - position.given;
    const double s = difference.cwiseProduct(position.inverse_sigma).squaredNorm();
    difference = (position.inverse_sigma.array() > 0).select(difference, kNaN);
    adjusted.positions.push_back({problem.images[position.image].id, difference, problem.position_loss.weight(s)});
  }
  std::sort(adjusted.positions.begin(), adjusted.positions.end(), [](auto& a, auto& b) { return a.image < b.image; });
}

}  // namespace collinea::bundle
