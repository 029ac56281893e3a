// SPDX-License-Identifier: Apache-2.0
#include "collinea/plan/control_layout.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

using Eigen::Vector2d;

/// The rectangle round the area along and across the strips, drawn in by the inset.
struct Frame {
  StripAxes axes;
  Vector2d low, high;  // along and across

  Frame(const FlightPlan& plan, std::optional<double> inset_m) : axes(plan.heading_rad) {
    low = Vector2d::Constant(1e300);
    high = -low;
    for (const Vector2d& corner : plan.area) {
      const Vector2d uv = axes.uv(corner);
      low = low.cwiseMin(uv);
      high = high.cwiseMax(uv);
    }
    const double shorter = (high - low).minCoeff(), inset = std::min(inset_m.value_or(shorter / 20), 0.45 * shorter);
    low += Vector2d::Constant(inset);
    high -= Vector2d::Constant(inset);
  }
  [[nodiscard]] Vector2d position(double u_share, double v_share) const {
    return axes.position(low.x() + u_share * (high.x() - low.x()), low.y() + v_share * (high.y() - low.y()));
  }
};

// The point of the area nearest to a corner of the frame; that itself where it is inside.
Vector2d drawn_into(const MapArea& area, const Vector2d& corner, const Vector2d& middle) {
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) {
    const Vector2d position = corner + (middle - corner) * (double(i) / kSteps);
    if (is_inside(area, position)) return position;
  }
  return middle;
}

std::vector<Vector2d> grid_of(const Frame& frame, const MapArea& area, int wanted) {
  const Vector2d size = frame.high - frame.low;
  const int columns = std::max(1, int(std::lround(std::sqrt(wanted * size.x() / size.y()))));
  const int rows = std::max(1, int(std::lround(double(wanted) / columns)));
  const auto share = [](int i, int count) { return count == 1 ? 0.5 : double(i) / (count - 1); };
  std::vector<Vector2d> positions;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      if (const Vector2d position = frame.position(share(column, columns), share(row, rows)); is_inside(area, position))
        positions.push_back(position);
  return positions;
}

}  // namespace

Result<std::vector<PlannedPoint>> lay_out(const LayoutOptions& o, const FlightPlan& plan) {
  COLLINEA_TRY(validate(o));
  const std::optional<ControlPattern> pattern = o.control.word();
  if (!pattern)
    return fail(Errc::kBadInput,
                "control = \"" + o.control.text() + "\": choose none, corners, corners_middle, grid or a file",
                {"control"_option});
  const Frame frame(plan, o.control_inset_m);
  std::vector<Vector2d> positions;
  if (pattern == ControlPattern::kGrid) positions = grid_of(frame, plan.area, o.control_points);
  if (pattern == ControlPattern::kCorners || pattern == ControlPattern::kCornersMiddle) {
    const Vector2d middle = frame.position(0.5, 0.5);
    for (const auto& [u, v] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}})
      positions.push_back(drawn_into(plan.area, frame.position(u, v), middle));
    if (pattern == ControlPattern::kCornersMiddle) positions.push_back(middle);
  }
  std::vector<PlannedPoint> points;
  for (const Vector2d& position : positions)
    points.push_back({"G" + std::to_string(points.size() + 1),
                      ControlRole::kControl,
                      position,
                      {o.control_sigma_plan_m, o.control_sigma_plan_m, o.control_sigma_height_m}});
  return points;
}

Result<std::vector<PlannedPoint>> planned_points(const ControlFile& file) {
  std::vector<PlannedPoint> points;
  for (const ControlFilePoint& point : file.points) {
    if (!point.correlation.isZero(0))
      return fail(Errc::kUnsupported,
                  "point " + point.name + " has a covariance: plan knows standard deviations of the axes only");
    points.push_back({point.name, point.role, point.position_in_map.head<2>(), point.sigma_m});
  }
  return points;
}

}  // namespace collinea
