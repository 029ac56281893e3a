// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/rectified_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "collinea/io/text.h"

namespace collinea {
namespace {

using nlohmann::json;

json json_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
json json_of(const Spread& spread) { return {{"middle", spread.middle}, {"worst_corner", spread.worst}}; }

void add(const RectifiedReport::FromPoints& from, json& out) {
  json& list = out["points"] = json::array();
  for (const RectifiedReport::Point& point : from.points)
    list.push_back({{"name", point.name},
                    {"residual_px", {point.residual_px.x(), point.residual_px.y()}},
                    {"residual_m", {point.residual_m.x(), point.residual_m.y()}},
                    {"in_sigmas", point.in_sigmas}});
  out["redundancy"] = from.redundancy;
  out["sigma_position_m"] = json_of(from.sigma_position_m);
  if (from.redundancy > 0) out["sigma0"] = from.sigma0;
}

std::string text_of(const RectifiedReport::FromPoints& from) {
  std::string text;
  if (from.redundancy > 0) {
    const auto worst = std::max_element(from.points.begin(), from.points.end(),
                                        [](const auto& a, const auto& b) { return a.in_sigmas < b.in_sigmas; });
    text += fmt::format("{} points, sigma0 {:.2f}; largest residual {:.2f} px, {} at point {}\n", from.points.size(),
                        from.sigma0, worst->residual_px.norm(), metres_text(worst->residual_m.norm()), worst->name);
    if (from.residuals_are_too_large)
      text +=
          "the residuals are larger than the sigmas stated allow: a point is wrong, does not lie on the plane, or the "
          "lens distorts\n";
  } else {
    text += "four points: nothing checks them\n";
  }
  text += fmt::format("standard deviation of a position by them: {} in the middle, {} in the worst corner\n",
                      metres_text(from.sigma_position_m.middle), metres_text(from.sigma_position_m.worst));
  if (from.focal_px)
    text += fmt::format("focal length from the perspective of the points: {:.0f} px, standard deviation {:.0f} px\n",
                        *from.focal_px, from.focal_sigma_px.value_or(0));
  return text;
}

}  // namespace

std::string rectified_json(const RectifiedReport& report) {
  json out = {{"cell_m", report.cell_m},     {"width", report.width}, {"height", report.height},
              {"left_m", report.left_m},     {"top_m", report.top_m}, {"painted_share", report.painted_share},
              {"photographs", json::array()}};
  for (const RectifiedReport::Source& source : report.sources) {
    json one = {{"file", source.file}, {"cells", source.cells}};
    if (source.centre_over_plane_m) one["centre_over_plane_m"] = json_of(*source.centre_over_plane_m);
    out["photographs"].push_back(one);
  }
  if (report.shift_per_depth) out["shift_per_depth"] = json_of(*report.shift_per_depth);
  if (report.from_points) add(*report.from_points, out);
  if (const auto& from = report.from_project)
    out["plane"] = {{"points", from->points},
                    {"points_looked_at", from->points_looked_at},
                    {"rms_m", from->rms_m},
                    {"origin_on_map", json_of(from->origin_on_map)},
                    {"origin_in_world", json_of(from->origin_in_world)},
                    {"x_axis_in_world", json_of(from->x_axis_in_world)},
                    {"y_axis_in_world", json_of(from->y_axis_in_world)},
                    {"normal_in_world", json_of(from->normal_in_world)}};
  return out.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string rectified_text(const RectifiedReport& report) {
  std::string text = fmt::format("{}: {} x {} cells of {}, {:.1f} % painted\n", report.file.string(), report.width,
                                 report.height, metres_text(report.cell_m), 100 * report.painted_share);
  if (const auto& shift = report.shift_per_depth)
    text += fmt::format("off the plane: 10 cm of depth shift a point by {} in the middle, {} in the worst corner\n",
                        metres_text(0.1 * shift->middle), metres_text(0.1 * shift->worst));
  else
    text += "off the plane: not known, the view is too frontal to say where the camera stood\n";
  if (report.from_points) text += text_of(*report.from_points);
  if (const auto& from = report.from_project)
    text += fmt::format(
        "plane of {} points of {}, {} off it (RMS)\n"
        "so points are shifted by {} in the middle, {} in the worst corner (RMS)\n",
        from->points, from->points_looked_at, metres_text(from->rms_m),
        metres_text(from->rms_m * from->shift_by_rms_per_m.middle),
        metres_text(from->rms_m * from->shift_by_rms_per_m.worst));
  if (!report.is_metric) text += "the block has no scale: lengths are in its own unit, not in metres\n";
  return text;
}

}  // namespace collinea
