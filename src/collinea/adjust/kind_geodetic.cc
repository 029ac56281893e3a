// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/kind_geodetic.h"

#include <algorithm>
#include <array>
#include <utility>

#include "collinea/adjust/block_motion.h"
#include "collinea/adjust/internal/datum_parts.h"

namespace collinea::bundle {
namespace {

// `auxiliaries`: the first of its own unknowns; null where it has none.
GeodeticModel model_at(const Problem& problem, const GeodeticLink& link, const Eigen::Vector3d& from,
                       const Eigen::Vector3d& to, const double* auxiliaries) {
  if (link.shape >= 0)
    return shape_model(link.observation, problem.shapes[static_cast<std::size_t>(link.shape)], auxiliaries, from,
                       problem.earth);
  return geodetic_model(link.observation, from, to, auxiliaries ? *auxiliaries : 0, problem.earth);
}

}  // namespace

GeodeticModel model_of(const Problem& problem, const GeodeticLink& link, const State& state) {
  return model_at(problem, link, Eigen::Vector3d(&state.points[3ul * link.from]),
                  Eigen::Vector3d(&state.points[3ul * link.to]),
                  link.auxiliary < 0 ? nullptr : &state.auxiliaries[static_cast<std::size_t>(link.auxiliary)]);
}

Row row_of(const Problem& problem, const GeodeticLink& link, const GeodeticModel& model) {
  const int globals_begin = 6 * problem.poses;
  Row row;
  const auto add_point = [&](std::uint32_t number, const Eigen::Vector3d& derivative) {
    const int first_retained = problem.point(number).first_retained;
    for (int c = 0; c < 3 && first_retained >= 0; ++c)  // fixed points have no unknowns
      row.push_back({globals_begin + first_retained + c, derivative[c]});
  };
  add_point(link.from, model.by_from);
  if (link.to != link.from) add_point(link.to, model.by_to);
  for (int k = 0; k < model.auxiliaries; ++k)
    row.push_back({globals_begin + problem.first_auxiliary + link.auxiliary + k,
                   model.by_auxiliary[static_cast<std::size_t>(k)]});
  return row;
}

Geodetic::Vector Geodetic::residual(const Problem& problem, const State& state, const Item& item) {
  return Vector(geodetic_residual(item.observation, model_of(problem, item, state)));
}

Row Geodetic::row(const Problem& problem, const State& state, const Item& item, int) {
  return row_of(problem, item, model_of(problem, item, state));
}

void Geodetic::add_to_gauge(const Problem& problem, const State& state, const BlockMotion& motion,
                            MotionNormals& normals) {
  for_each(problem, [&](const GeodeticLink& link) {
    const Eigen::Vector3d from = motion.moved * Eigen::Vector3d(&state.points[3ul * link.from]);
    const Eigen::Vector3d to = motion.moved * Eigen::Vector3d(&state.points[3ul * link.to]);
    const auto first = static_cast<std::size_t>(std::max(link.auxiliary, 0));
    std::array<double, 3> auxiliary{};
    for (std::size_t k = 0; k < 3 && link.auxiliary >= 0 && first + k < state.auxiliaries.size(); ++k)
      auxiliary[k] = motion.moved_auxiliary(problem.auxiliaries[first + k], state.auxiliaries[first + k]);
    const GeodeticModel model = model_at(problem, link, from, to, auxiliary.data());
    Row7 row = model.by_from.transpose() * motion.derivatives_at(from);
    if (link.to != link.from) row += model.by_to.transpose() * motion.derivatives_at(to);
    if (link.auxiliary >= 0)
      motion.add_auxiliary(problem.auxiliaries[first], state.auxiliaries[first], model.by_auxiliary[0], row);
    row *= link.inverse_sigma;
    const double residual = geodetic_residual(link.observation, model) * link.inverse_sigma;
    normals.matrix += row.transpose() * row;
    normals.right += row.transpose() * residual;
    normals.cost += residual * residual;
  });
}

void Geodetic::observe_rows(const Problem& problem, const State& state, std::vector<DatumPart>& parts,
                            MotionsWithAuxiliaries& rows) {
  for_each(problem, [&](const GeodeticLink& link) {
    const int part = problem.part_of_point[link.from];
    if (part < 0 || part != problem.part_of_point[link.to]) return;
    DatumPart& its = parts[part];
    const GeodeticModel model = model_of(problem, link, state);
    Row7 seen = Row7::Zero();
    for (const auto& [point, derivative] : {std::pair(link.from, &model.by_from), std::pair(link.to, &model.by_to)})
      if (!problem.is_unseen(point))
        seen += derivative->transpose() * motion_of(Eigen::Vector3d(&state.points[3ul * point]), its.centre, its.size);
    Row row = row_of(problem, link, model);
    if (const double length = seen.norm(); length > 0) {
      seen /= length;
      for (RowPart& entry : row) entry.derivative = entry.row < 6 * problem.poses ? 0 : entry.derivative / length;
    }
    rows.add(part, seen, row);
    its.sources.geodetic = true;
  });
}

void Geodetic::tabulate(const Problem& problem, const State& state, Adjusted& adjusted) {
  for (const GeodeticLink& link : problem.geodetic) {
    const double difference = -geodetic_residual(link.observation, model_of(problem, link, state));
    adjusted.geodetic.push_back({.observation = link.source,
                                 .used = link.inverse_sigma > 0,
                                 .adjusted = link.observation.value + difference,
                                 .difference = difference});
  }
}

}  // namespace collinea::bundle
