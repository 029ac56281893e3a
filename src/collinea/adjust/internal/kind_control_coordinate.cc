// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/kind_control_coordinate.h"

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/internal/datum_parts.h"

namespace collinea::bundle {

void ControlCoordinate::add_to_gauge(const Problem& problem, const State& state, const BlockMotion& motion,
                                     MotionNormals& normals) {
  for_each(problem, [&](Item p) {
    const ControlCoordinates& control = problem.control[problem.point(p).control];
    normals.add_position(motion, Eigen::Map<const Eigen::Vector3d>(&state.points[3 * p]),
                         Eigen::Map<const Eigen::Vector3d>(control.given), control.weight(), Loss{});
  });
}

void ControlCoordinate::observe_motions(const Problem& problem, const State& state, std::size_t p,
                                        std::vector<DatumPart>& parts) {
  const ProblemPoint& point = problem.point(p);
  if (point.is_fixed || point.control < 0) return;
  DatumPart& its = parts[problem.part_of_point[p]];
  const Eigen::Map<const Eigen::Array3d> inverse_sigma(problem.control[point.control].inverse_sigma);
  its.add(Eigen::Map<const Eigen::Vector3d>(&state.points[3 * p]), (inverse_sigma > 0).cast<double>());
  its.sources.control |= inverse_sigma.maxCoeff() > 0;
}

}  // namespace collinea::bundle
