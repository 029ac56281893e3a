// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/internal/gather_geodetic.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "collinea/adjust/kind_geodetic.h"
#include "collinea/block/geodetic_words.h"

namespace collinea::bundle {
namespace {

using ShapeKey = std::pair<GeodeticKind, std::uint32_t>;

ShapeKey key_of(const GeodeticObservation& measured) { return {measured.kind, measured.setup}; }

UnknownKind unknown_of(GeodeticKind kind) {
  UnknownKind unknown{};
  geodetic::visit_kind<geodetic::ShapeKinds>(kind, [&]<class Shape>() { unknown = Shape::kUnknown; });
  return unknown;
}

Earth earth_of(const Block& block) {
  if (!block.georeference) return {};
  const double latitude = block.georeference->origin_latitude_deg * std::numbers::pi / 180;
  return {.is_round = true,
          .pole = {0, std::cos(latitude), std::sin(latitude)},
          .deflection_rad = {block.georeference->deflection_north_rad, block.georeference->deflection_east_rad}};
}

/// The points of a shape that take part: those that determine it, and all.
struct Members {
  std::set<ControlId> used, all;
};

std::map<ShapeKey, Members> members_of(const Block& block, const std::vector<std::uint32_t>& links) {
  std::map<ShapeKey, Members> shapes;
  for (const std::uint32_t link : links) {
    const GeodeticObservation& measured = block.geodetic[link];
    if (!measured.is_of_shape()) continue;
    Members& members = shapes[key_of(measured)];
    members.all.insert(measured.from);
    if (measured.role == ControlRole::kControl) members.used.insert(measured.from);
  }
  return shapes;
}

std::vector<Eigen::Vector3d> positions_of(const std::set<ControlId>& points,
                                          const std::function<Eigen::Vector3d(ControlId)>& position_of) {
  std::vector<Eigen::Vector3d> positions;
  for (const ControlId point : points) positions.push_back(position_of(point));
  return positions;
}

class GeodeticLayout {
 public:
  GeodeticLayout(const Block& block, ProblemAndStart& out) : block_(block), problem_(out.problem), start_(out.start) {
    for (std::size_t p = 0; p < problem_.point_count(); ++p)
      if (problem_.point(p).control >= 0) number_[ControlId{problem_.point(p).id}] = static_cast<std::uint32_t>(p);
  }

  void lay_out(const std::vector<std::uint32_t>& links) {
    problem_.earth = earth_of(block_);
    begin_shapes(links);
    for (const std::uint32_t source : links) {
      const GeodeticObservation& measured = block_.geodetic[source];
      GeodeticLink link{measured, source, number_.at(measured.from), number_.at(measured.to)};
      if (measured.role == ControlRole::kControl) link.inverse_sigma = 1 / measured.sigma;
      if (measured.kind == GeodeticKind::kDirection) link.auxiliary = orientation_of(measured, link);
      if (measured.is_of_shape()) {
        const auto& [shape, auxiliary] = shapes_.at(key_of(measured));
        link.shape = shape;
        link.auxiliary = auxiliary + (measured.kind == GeodeticKind::kOnLine ? 2 * measured.axis : 0);
      }
      problem_.geodetic.push_back(link);
      problem_.retained_points.insert(problem_.retained_points.end(), {link.from, link.to});
    }
    join();
  }

 private:
  void begin_shapes(const std::vector<std::uint32_t>& links) {
    const auto position_of = [&](ControlId id) { return Eigen::Vector3d(&start_.points[3ul * number_.at(id)]); };
    for (const auto& [key, members] : members_of(block_, links)) {
      const std::vector<Eigen::Vector3d> positions = positions_of(members.used, position_of);
      const auto shape = shape_through(key.first, positions);
      COLLINEA_CHECK(shape.has_value());
      shapes_[key] = {static_cast<int>(problem_.shapes.size()), static_cast<int>(problem_.auxiliaries.size())};
      problem_.shapes.push_back(*shape);
      const int unknowns = unknowns_of_shape(key.first);
      for (int axis = 0; axis < unknowns; ++axis)
        problem_.auxiliaries.push_back({unknown_of(key.first), key.second, axis});
      start_.auxiliaries.resize(problem_.auxiliaries.size(), 0);
      if (key.first != GeodeticKind::kAtHeight) continue;
      constexpr double kZero = 0;
      for (const Eigen::Vector3d& position : positions)
        start_.auxiliaries.back() +=
            shape_model({.kind = key.first}, *shape, &kZero, position, problem_.earth).computed /
            static_cast<double>(positions.size());
    }
  }

  int orientation_of(const GeodeticObservation& measured, const GeodeticLink& link) {
    const auto [its, first] = orientations_.try_emplace(measured.setup, static_cast<int>(problem_.auxiliaries.size()));
    if (!first) return its->second;
    problem_.auxiliaries.push_back({UnknownKind::kOrientation, measured.setup});
    // By its first direction; those that follow are at most a turn away, and residuals of angles know no turns.
    start_.auxiliaries.push_back(-geodetic_residual(measured, model_of(problem_, link, start_)));
    return its->second;
  }

  void join() {
    problem_.global_count += static_cast<int>(problem_.auxiliaries.size());
    std::sort(problem_.retained_points.begin(), problem_.retained_points.end());
    problem_.retained_points.erase(std::unique(problem_.retained_points.begin(), problem_.retained_points.end()),
                                   problem_.retained_points.end());
    std::erase_if(problem_.retained_points, [&](std::uint32_t p) { return problem_.point(p).is_fixed; });
    for (const std::uint32_t p : problem_.retained_points) {
      problem_.points[p].first_retained = problem_.global_count;
      problem_.global_count += 3;
    }
  }

  const Block& block_;
  Problem& problem_;
  State& start_;
  std::map<ControlId, std::uint32_t> number_;
  std::map<std::uint32_t, int> orientations_;       // of set-ups, in Problem::auxiliaries
  std::map<ShapeKey, std::pair<int, int>> shapes_;  // number of the shape, and of its first unknown
};

}  // namespace

Result<std::vector<std::uint32_t>> geodetic_taking_part(const Block& block, const AdjustScope& scope) {
  std::vector<std::uint32_t> links;
  if (!scope.use_geodetic || scope.free_images) return links;
  for (std::size_t i = 0; i < block.geodetic.size(); ++i) {
    const GeodeticObservation& measured = block.geodetic[i];
    if (!(measured.sigma > 0) || !std::isfinite(measured.sigma) || !std::isfinite(measured.value))
      return fail(Errc::kBadInput, words_of(measured, block) + " is no number with a positive standard deviation");
    if (!measured.is_of_shape() && measured.from == measured.to)
      return fail(Errc::kBadInput, "a measurement joins " + block.control.at(measured.from).name + " with itself");
    if (measured.is_of_shape() && (measured.from != measured.to || measured.axis < 0 || measured.axis > 1))
      return fail(Errc::kBadInput, words_of(measured, block) + " is given for two points, or on no axis");
    links.push_back(static_cast<std::uint32_t>(i));
  }
  return links;
}

std::set<ControlId> points_of(const Block& block, const std::vector<std::uint32_t>& geodetic) {
  std::set<ControlId> points;
  for (const std::uint32_t source : geodetic) points.insert({block.geodetic[source].from, block.geodetic[source].to});
  return points;
}

void erase_weak_shapes(const Block& block, const std::function<Eigen::Vector3d(ControlId)>& position_of,
                       std::vector<std::uint32_t>& geodetic) {
  const auto shapes = members_of(block, geodetic);
  std::set<ShapeKey> weak;
  for (const auto& [key, members] : shapes)
    if (static_cast<int>(members.all.size()) <= points_of_shape(key.first) ||
        !shape_through(key.first, positions_of(members.used, position_of)))
      weak.insert(key);
  std::erase_if(geodetic, [&](std::uint32_t source) {
    return block.geodetic[source].is_of_shape() && weak.contains(key_of(block.geodetic[source]));
  });
}

std::map<ControlId, int> geodetic_counts(const Block& block, const std::vector<std::uint32_t>& geodetic) {
  std::map<std::uint32_t, int> directions;  // of each set-up
  for (const std::uint32_t source : geodetic)
    if (const GeodeticObservation& one = block.geodetic[source];
        one.kind == GeodeticKind::kDirection && one.role == ControlRole::kControl)
      ++directions[one.setup];
  std::map<ControlId, int> counts;
  std::set<std::pair<ControlId, std::uint32_t>> oriented;
  for (const std::uint32_t source : geodetic) {
    const GeodeticObservation& one = block.geodetic[source];
    const bool counts_here =
        one.role == ControlRole::kControl && (one.kind != GeodeticKind::kDirection || directions.at(one.setup) >= 2);
    for (const ControlId point : std::set{one.from, one.to}) counts[point] += counts_here;
    if (counts_here && one.kind == GeodeticKind::kDirection && oriented.insert({one.from, one.setup}).second)
      --counts[one.from];
  }
  return counts;
}

void lay_out_geodetic(const Block& block, const std::vector<std::uint32_t>& geodetic, ProblemAndStart& out) {
  GeodeticLayout(block, out).lay_out(geodetic);
}

}  // namespace collinea::bundle
