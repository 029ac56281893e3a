// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/resection_station.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/geometry/planar_resection.h"
#include "collinea/jobs/internal/danger_shape.h"
#include "collinea/jobs/internal/pose_estimates.h"
#include "collinea/jobs/internal/rejection.h"

namespace collinea {

using Eigen::Matrix3d;
using Eigen::Vector2d;
constexpr double kDegrees = 180 / std::numbers::pi;

namespace {

struct Directions {
  std::vector<PlanarDirection> directions;
  std::vector<std::size_t> rows;  // of the table
};

Directions directions_of(const ResectionTables& tables) {
  Directions out;
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const ResectionRow& mark = tables.marks[i];
    const GroundTablePoint* known = tables.ground.find(mark.point);
    if (mark.is_rejected || !known || !known->position.head<2>().allFinite()) continue;
    out.directions.push_back({known->position.head<2>(), mark.xy.x(), mark.sigma});
    out.rows.push_back(i);
  }
  return out;
}

Result<> leave_out_by_median(ResectionTables& tables, std::uint64_t seed) {
  const Directions all = directions_of(tables);
  const auto wrong = contradicting_directions(all.directions, seed);
  if (!wrong)
    return fail(Errc::kIllPosed,
                "the least median of squares needs five directions, of which those that agree determine the station",
                {"least_median"_option});
  for (const std::size_t k : *wrong) tables.marks[all.rows[k]].is_rejected = true;
  return {};
}

std::optional<PlanarResection> fitted(ResectionTables& tables, const ResectOneOptions& options) {
  return fitted_with_rejection(
      Rejection{options.reject, tables.sigmas_are_stated, options.alpha, 1},
      [&] { return planar_resection(directions_of(tables).directions); },
      [](const PlanarResection& found) -> const auto& { return found.w; },
      [&](std::size_t k) -> bool& { return tables.marks[directions_of(tables).rows[k]].is_rejected; });
}

constexpr double kMgon = 200e3 / std::numbers::pi;

void add_marks(const ResectionTables& tables, const PlanarResection& found, ResectionReport& report) {
  const Directions all = directions_of(tables);
  std::size_t next = 0;
  for (std::size_t i = 0; i < tables.marks.size(); ++i) {
    const ResectionRow& mark = tables.marks[i];
    if (next < all.rows.size() && all.rows[next] == i) {
      report.marks.push_back({mark.image, mark.point, Vector2d(kMgon * found.misfits_rad[next], 0),
                              Vector2d(found.redundancies[next], 0),
                              Vector2d(found.w[next] / report.variance.of_tests(), 0)});
      ++next;
    } else if (mark.is_rejected) {
      const Vector2d to = tables.ground.find(mark.point)->position.head<2>() - found.station;
      const double off =
          std::remainder(mark.xy.x() - std::atan2(to.x(), to.y()) + found.orientation_rad, 2 * std::numbers::pi);
      report.marks.push_back(
          {mark.image, mark.point, Vector2d(kMgon * off, 0), Vector2d::Zero(), Vector2d::Zero(), true});
    }
  }
}

std::vector<ResectionReport::Image::Control> control_of(const ResectionTables& tables) {
  const Directions all = directions_of(tables);
  std::vector<ResectionReport::Image::Control> out;
  for (std::size_t k = 0; k < all.rows.size(); ++k)
    out.push_back({tables.marks[all.rows[k]].point, {all.directions[k].to.x(), all.directions[k].to.y(), 0}});
  return out;
}

void set_danger(const ResectionTables& tables, const Vector2d& station, ResectionReport::Image& image) {
  std::vector<Vector2d> points;
  for (const PlanarDirection& one : directions_of(tables).directions) points.push_back(one.to);
  const auto circle = danger_circle(points);
  if (!circle) return;
  image.danger = DangerCylinder{circle->radius,
                                circle->points_off,
                                (station - circle->centre).norm() - circle->radius,
                                {circle->centre.x(), circle->centre.y(), 0}};
  image.control = control_of(tables);
  image.station = {station.x(), station.y(), 0};
}

// The station anywhere on the arc that its directions leave open, where they do.
ResectionReport without_solution(const ResectionTables& tables) {
  constexpr int kSteps = 60;
  ResectionReport report;
  report.kind = ResectionReport::Kind::kStation;
  const auto arc = open_arc(directions_of(tables).directions);
  if (!arc) return report;
  ResectionReport::Image image{tables.images[0]};
  std::vector<Vector2d> stations;
  for (int i = 0; i <= kSteps; ++i) {
    const double at = arc->from_rad + (arc->to_rad - arc->from_rad) * i / kSteps;
    stations.emplace_back(arc->circle.centre + arc->circle.radius * Vector2d(std::cos(at), std::sin(at)));
    image.open_stations.emplace_back(stations.back().x(), stations.back().y(), 0);
  }
  set_danger(tables, stations[kSteps / 2], image);
  report.images.push_back(std::move(image));
  return report;
}

}  // namespace

Result<ResectionReport> of_station(ResectionTables& tables, const ResectOneOptions& options) {
  if (tables.images.size() > 1)
    return fail(Errc::kBadInput, fmt::format("the table has {} stations: give one", tables.images.size()));
  if (options.least_median) COLLINEA_TRY(leave_out_by_median(tables, options.seed));
  const auto found = fitted(tables, options);
  const std::size_t count = directions_of(tables).directions.size();
  if (!found) {
    auto failed = fail(Errc::kIllPosed,
                       fmt::format("{} directions do not determine the station: three to points apart are needed, and "
                                   "it must not lie on the circle through them",
                                   count));
    return tl::unexpected(with_danger(std::move(failed.value()), without_solution(tables), options));
  }
  ResectionReport report;
  report.unit = "mgon";
  report.variance = {found->sigma0, found->redundancy, tables.sigmas_are_stated, options.alpha};
  report.kind = ResectionReport::Kind::kStation;
  const double factor = report.variance.factor();
  ResectionReport::Image image{tables.images[0], count};
  Matrix3d by = Matrix3d::Identity();
  by(2, 2) = kDegrees;
  image.covariance = factor * factor * by * found->covariance * by;
  image.exterior = {{"X", "m", found->station.x()},
                    {"Y", "m", found->station.y()},
                    {"orientation", "deg", found->orientation_rad * kDegrees}};
  add_sigmas(image.exterior, image.covariance);
  set_danger(tables, found->station, image);
  report.images.push_back(std::move(image));
  add_marks(tables, *found, report);
  return report;
}

}  // namespace collinea
