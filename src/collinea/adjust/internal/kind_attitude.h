// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/adjusted.h"
#include "collinea/adjust/internal/observation.h"
#include "collinea/adjust/observation_group.h"

namespace collinea::bundle {

/// The attitude of an image by an inertial system: the turn from the adjusted to the given attitude, about x, y and z
/// of the world. Between the system and the camera lies a boresight b, about the camera's axes, as far as the scope has
/// it: cam_from_world = rotation_by(b) * given.
struct Attitude : ObservationKind<Attitude, 3> {
  using Item = GivenRotation;

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (const Item& item : problem.attitudes) visit(item);
  }
  static Eigen::Vector3d residual(const Problem&, const State& state, const Item& item);
  static Eigen::Vector3d inverse_sigma(const Problem&, const Item& item) { return item.inverse_sigma; }
  static Row row(const Problem& problem, const State& state, const Item& item, int axis);
  static Eigen::Vector3d predicted(const Problem& problem, const State& state, const State& next,
                                   const std::vector<double>& reduced, const Item& item);

  static ObservationGroup group(const Item&, int axis) { return group_of(ObservationSource::kAttitude, axis); }
  static std::uint32_t source(const Problem& problem, const Item& item) { return problem.images[item.image].id.value; }
  static bool is_gauge_complete(const Problem& problem) { return problem.attitudes.empty(); }
  static bool needs_rows_for_datum(const Problem& problem) { return !problem.attitudes.empty(); }
  static void observe_rows(const Problem& problem, const State& state, std::vector<DatumPart>& parts,
                           MotionsWithAuxiliaries& rows);
  static void tabulate(const Problem& problem, const State& state, Adjusted& adjusted);
};

/// Given minus adjusted attitude, as a turn in the world, and the derivative of the adjusted one about one of its axes.
[[nodiscard]] Eigen::Vector3d residual_of(const State& state, const GivenRotation& given);
[[nodiscard]] Row row_of(const Problem& problem, const State& state, const GivenRotation& given, int axis);

}  // namespace collinea::bundle
