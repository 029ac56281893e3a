// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/adjusted.h"
#include "collinea/adjust/internal/observation.h"
#include "collinea/adjust/observation_group.h"

namespace collinea::bundle {

/// The position of a GNSS antenna at an exposure, in the world frame:
///
///     a = c + R' l + s + t d + o v
///
/// with the projection centre c, the rotation R (cam_from_world), the lever arm l in the camera, shift s and drift d of
/// its track at the time t, and the time offset o at the velocity v. Each beyond c only as far as the scope has it.
/// Robust, by the loss of positions; plan and height share it.
struct GnssPosition : ObservationKind<GnssPosition, 3> {
  using Item = GivenPosition;
  static constexpr bool kIsRobust = true;
  static constexpr ObservationSource kGivenBy = ObservationSource::kPosition;

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (const Item& item : problem.positions) visit(item);
  }
  static Loss loss(const Problem& problem) { return problem.position_loss; }
  static Eigen::Vector3d residual(const Problem& problem, const State& state, const Item& item);
  static Eigen::Vector3d inverse_sigma(const Problem&, const Item& item) { return item.inverse_sigma; }
  static Row row(const Problem& problem, const State& state, const Item& item, int axis);
  /// Those of projection centres have one derivative, which is 1.
  static double add(const Problem& problem, const State& state, const Item& item, ObservationSink& sink);

  static ObservationGroup group(const Item&, int axis) { return group_of(kGivenBy, axis); }
  static std::uint32_t source(const Problem& problem, const Item& item) { return problem.images[item.image].id.value; }
  static bool positions_block(const Problem& problem) { return !problem.positions.empty(); }
  static bool is_gauge_complete(const Problem& problem);
  /// What lies between centre and antenna is taken as it is.
  static void add_to_gauge(const Problem& problem, const State& state, const BlockMotion& motion,
                           MotionNormals& normals);
  static void observe_motions(const Problem& problem, const State& state, std::vector<DatumPart>& parts);
  static void observe_rows(const Problem& problem, const State& state, std::vector<DatumPart>& parts,
                           MotionsWithAuxiliaries& rows);

  /// Differences on axes that were not given are NaN.
  static void tabulate(const Problem& problem, const State& state, Adjusted& adjusted);
};

/// The computed position of the antenna, and its derivatives along an axis of the world.
[[nodiscard]] Eigen::Vector3d antenna_of(const State& state, const GivenPosition& position);
[[nodiscard]] Row row_of(const Problem& problem, const State& state, const GivenPosition& position, int axis);

}  // namespace collinea::bundle
