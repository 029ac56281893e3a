// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/kind_geodetic.h"

namespace collinea::bundle {

GeodeticModel model_of(const Problem& problem, const GeodeticLink& link, const State& state) {
  const Eigen::Vector3d from(&state.points[3ul * link.from]);
  const double* extra = link.extra < 0 ? nullptr : &state.auxiliaries[static_cast<std::size_t>(link.extra)];
  if (link.shape >= 0)
    return shape_model(link.observation, problem.shapes[static_cast<std::size_t>(link.shape)], extra, from,
                       problem.level_at_origin);
  return geodetic_model(link.observation, from, Eigen::Vector3d(&state.points[3ul * link.to]), extra ? *extra : 0,
                      problem.level_at_origin);
}

Row row_of(const Problem& problem, const GeodeticLink& link, const GeodeticModel& model) {
  const int border = 6 * problem.poses;
  Row row;
  const auto add_point = [&](std::uint32_t number, const Eigen::Vector3d& derivative) {
    const int joined = problem.point(number).joined;
    for (int c = 0; c < 3 && joined >= 0; ++c)  // held points have no unknowns
      row.push_back({border + joined + c, derivative[c]});
  };
  add_point(link.from, model.by_from);
  if (link.to != link.from) add_point(link.to, model.by_to);
  for (int k = 0; k < model.auxiliaries; ++k)
    row.push_back({border + problem.first_extra + link.extra + k, model.by_extra[static_cast<std::size_t>(k)]});
  return row;
}

Geodetic::Vector Geodetic::residual(const Problem& problem, const State& state, const Item& item) {
  return Vector(geodetic_residual(item.observation, model_of(problem, item, state)));
}

Row Geodetic::row(const Problem& problem, const State& state, const Item& item, int) {
  return row_of(problem, item, model_of(problem, item, state));
}

void Geodetic::tabulate(const Problem& problem, const State& state, Adjusted& adjusted) {
  for (const GeodeticLink& link : problem.ground) {
    const double difference = -geodetic_residual(link.observation, model_of(problem, link, state));
    adjusted.ground.push_back({.observation = link.source,
                               .used = link.inverse_sigma > 0,
                               .adjusted = link.observation.value + difference,
                               .difference = difference});
  }
}

}  // namespace collinea::bundle
