// SPDX-License-Identifier: Apache-2.0
#include "collinea/plan/rules_of_thumb.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr double kSuperWide_rad = 110 * std::numbers::pi / 180;  // field of view over the diagonal

double plan_rms(const Eigen::Vector3d& rms_m) { return std::sqrt((rms_m.x() * rms_m.x() + rms_m.y() * rms_m.y()) / 2); }

// Images with six and more tie points of three and more rays.
std::size_t well_tied(const Precision& precision) {
  std::map<PointId, int> rays;
  for (const Observation& seen : precision.planned.block.observations) ++rays[seen.point];
  std::map<ImageId, int> points;
  for (const Observation& seen : precision.planned.block.observations) points[seen.image] += rays.at(seen.point) > 2;
  return std::size_t(std::count_if(points.begin(), points.end(), [](const auto& its) { return its.second >= 6; }));
}

}  // namespace

std::vector<RuleOfThumb> rules_of_thumb(const FlightPlan& plan, const FlightOptions& flight,
                                        const MeasurementOptions& options, const Precision& precision) {
  const double h = plan.height_m, mb = h / (1e-3 * flight.focal_mm);
  const Camera& camera = plan.camera;
  const double field = 2 * std::atan(0.5 * std::hypot(camera.width_px, camera.height_px) / camera.focal_px());
  const bool super_wide = field > kSuperWide_rad;
  const double plan_m = 6e-6 * mb, height_m = (super_wide ? 0.08e-3 : 0.06e-3) * h;
  const auto natural = [](double signalised_m, double defined_m) { return std::hypot(signalised_m, defined_m); };
  const double parallax_m = h / plan.base_m * plan.gsd_m * std::numbers::sqrt2 * options.sigma_px;
  return {{PlanRule::kSignalisedPlan, plan_m, plan_rms(precision.area.rms_m)},
          {super_wide ? PlanRule::kSignalisedHeightSuperWide : PlanRule::kSignalisedHeight, height_m,
           precision.area.rms_m.z()},
          {PlanRule::kNormalCaseHeight, parallax_m, std::nullopt},
          {PlanRule::kManholePlan, natural(plan_m, 0.05), std::nullopt},
          {PlanRule::kManholeHeight, natural(height_m, 0.02), std::nullopt},
          {PlanRule::kCornerPlan, natural(plan_m, 0.095), std::nullopt},
          {PlanRule::kCornerHeight, natural(height_m, 0.115), std::nullopt},
          {PlanRule::kLinesPlan, 45e-6 * mb, std::nullopt},
          {PlanRule::kContours, 0.25e-3 * h, std::nullopt}};
}

namespace {

// Four points that lie each nearer to another corner of the site than a third of the site's shorter side.
bool holds_corners(const FlightPlan& plan, const std::vector<PlannedPoint>& points) {
  const auto corners = lay_out({.control = ControlPattern::kCorners}, plan);
  if (!corners) return false;
  double near_m = 1e300;
  for (std::size_t i = 0; i < corners->size(); ++i)
    near_m = std::min(near_m, ((*corners)[i].position - (*corners)[(i + 1) % corners->size()].position).norm() / 3);
  return std::all_of(corners->begin(), corners->end(), [&](const PlannedPoint& corner) {
    return std::any_of(points.begin(), points.end(), [&](const PlannedPoint& point) {
      return point.role == ControlRole::kControl && (point.position - corner.position).norm() <= near_m;
    });
  });
}

}  // namespace

std::vector<Custom> customs(const FlightPlan& plan, const FlightOptions& flight,
                            const std::vector<PlannedPoint>& points, const Precision& precision) {
  return {{PlanCustom::kForwardOverlap, flight.forward_overlap >= 0.6},
          {PlanCustom::kSideOverlap, flight.side_overlap >= 0.2},
          {PlanCustom::kTiePoints, well_tied(precision) == plan.images.size()},
          {PlanCustom::kControlAtCorners, holds_corners(plan, points)}};
}

}  // namespace collinea
