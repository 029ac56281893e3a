// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/internal/observation.h"

namespace collinea::bundle {

/// The direction of the plumb line in the camera of an image: the chord between the given and the adjusted unit vector.
/// Three coordinates that count as two observations, across the direction; along it the derivative is zero. It is not
/// tested: it comes from how images are held, or from an attitude that a camera wrote down.
struct Vertical : ObservationKind<Vertical, 3> {
  using Item = GivenUp;
  static constexpr bool kIsTested = false;

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (const Item& item : problem.verticals) visit(item);
  }
  static long count(const Problem&, const Item&) { return 2; }
  static Eigen::Vector3d whitened(const Problem&, const State& state, const Item& item) {
    return item.residual(z_in_cam(state.frames[item.image]));
  }
  static double add(const Problem& problem, const State& state, const Item& item, ObservationSink& sink);
  static Eigen::Vector3d predicted(const Problem& problem, const State& state, const State& next,
                                   const std::vector<double>& reduced, const Item& item);
  static void add_to_gauge(const Problem& problem, const State& state, const BlockMotion& motion,
                           MotionNormals& normals);
  /// Turns about the two level axes.
  static void observe_motions(const Problem& problem, const State& state, std::vector<DatumPart>& parts);
  /// The redundancy of both observations together, by the cofactors of the turn of the image.
  static double redundancy(const State& state, const Item& item, const Eigen::Matrix3d& cofactor);
};

}  // namespace collinea::bundle
