// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/adjust/adjusted.h"
#include "collinea/adjust/geodetic_model.h"
#include "collinea/adjust/internal/observation.h"
#include "collinea/adjust/observation_group.h"

namespace collinea::bundle {

/// A measurement between two points (distance, height difference, direction, zenith angle), or that a point lies at a
/// common height, on a plane or on a line: GeodeticKind says which, its model is in the file of that name
/// (geodetic_model(), shape_model()). The points keep their unknowns; directions have the orientation of their set-up
/// in common, points of a shape its unknowns. What is only compared does not take part.
struct Geodetic : ObservationKind<Geodetic, 1> {
  using Item = GeodeticLink;

  template <class Visit>
  static void for_each(const Problem& problem, Visit&& visit) {
    for (const Item& item : problem.geodetic)
      if (item.inverse_sigma > 0) visit(item);
  }
  static Vector residual(const Problem& problem, const State& state, const Item& item);
  static Vector inverse_sigma(const Problem&, const Item& item) { return Vector(item.inverse_sigma); }
  static Row row(const Problem& problem, const State& state, const Item& item, int axis);

  static ObservationGroup group(const Item& item, int) { return group_of(item.observation.kind); }
  static std::uint32_t source(const Problem&, const Item& item) { return item.source; }
  static double sigma(const Problem&, const Item& item, int) { return item.observation.sigma; }
  static double leverage(double, double inverse_sigma, double cofactor) {
    return cofactor * inverse_sigma * inverse_sigma;
  }
  /// It sees the scale, the level and, where only one end moves, the position.
  static bool is_gauge_complete(const Problem& problem) { return problem.geodetic.empty(); }
  static void add_to_gauge(const Problem& problem, const State& state, const BlockMotion& motion,
                           MotionNormals& normals);
  /// As far as the direction of the derivatives goes: by their length they are all the same.
  static bool needs_rows_for_datum(const Problem& problem) { return !problem.geodetic.empty(); }
  static void observe_rows(const Problem& problem, const State& state, std::vector<DatumPart>& parts,
                           MotionsWithAuxiliaries& rows);
  /// Also of what is only compared.
  template <class Visit>
  static void for_each_tied_points(const Problem& problem, Visit&& visit) {
    for (const Item& item : problem.geodetic) visit(item.from, item.to);
  }

  /// Also of what is only compared.
  static void tabulate(const Problem& problem, const State& state, Adjusted& adjusted);
};

/// A measurement as the unknowns predict it, and its derivatives by them.
[[nodiscard]] GeodeticModel model_of(const Problem& problem, const GeodeticLink& link, const State& state);
[[nodiscard]] Row row_of(const Problem& problem, const GeodeticLink& link, const GeodeticModel& model);

}  // namespace collinea::bundle
