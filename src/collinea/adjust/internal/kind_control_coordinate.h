// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/internal/observation.h"
#include "collinea/adjust/point_normals.h"

namespace collinea::bundle {

/// The surveyed coordinates of a control point, with their correlations. Their only derivatives are by the point
/// itself: they enter its own normal equations (PointNormals::add) with its image points, before the point is
/// eliminated or, where other observations share it, among the global parameters (Normals). Tests take the correlations
/// into account, see reliability_of().
struct ControlCoordinate : ObservationKind<ControlCoordinate, 3> {
  using Item = std::size_t;  ///< number in Problem::points
  static constexpr bool kIsOfPoint = true;

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (Item p = problem.first_control; p < problem.point_count(); ++p)
      if (problem.point(p).control >= 0) visit(p);
  }
  static Eigen::Vector3d inverse_sigma(const Problem& problem, Item p) {
    return Eigen::Map<const Eigen::Vector3d>(problem.control[problem.point(p).control].inverse_sigma);
  }
  static double squared(const Problem& problem, const State& state, Item p) {
    return PointNormals().add(problem.control[problem.point(p).control], &state.points[3 * p]);
  }

  static bool positions_block(const Problem& problem) { return !problem.control.empty(); }
  static void add_to_gauge(const Problem& problem, const State& state, const BlockMotion& motion,
                           MotionNormals& normals);
  /// Those of point p, which a free image shows.
  static void observe_motions(const Problem& problem, const State& state, std::size_t p, std::vector<DatumPart>& parts);
};

}  // namespace collinea::bundle
