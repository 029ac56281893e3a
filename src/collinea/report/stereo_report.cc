// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/stereo_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "collinea/report/internal/level_table.h"

namespace collinea {
namespace {

// The camera as numbers: focal length, principal point, size.
nlohmann::json json_of(const Camera& camera) {
  return {{"f_px", camera.focal_px()},
          {"cx_px", camera.params[Camera::kCx]},
          {"cy_px", camera.params[Camera::kCy]},
          {"width_px", camera.width_px},
          {"height_px", camera.height_px}};
}

}  // namespace

std::string stereo_json(const StereoReport& report) {
  nlohmann::json json = {{"matcher", word_of(report.matcher)},
                         {"min_disparity_px", report.min_disparity_px},
                         {"max_disparity_px", report.max_disparity_px},
                         {"pixels", report.pixels},
                         {"measured", report.measured},
                         {"median_sigma_px", nullptr}};
  if (report.median_sigma_px) json["median_sigma_px"] = *report.median_sigma_px;
  for (const LevelCount& level : report.levels)
    json["levels"].push_back({{"shrink", level.shrink},
                              {"threshold", level.threshold},
                              {"interest", level.interest},
                              {"matched", level.matched},
                              {"grown", level.grown},
                              {"spikes", level.spikes},
                              {"median_interval_px", level.median_interval_px}});
  if (report.cameras) {
    const StereoReport::Cameras& cameras = *report.cameras;
    json["left"] = json_of(cameras.left);
    json["right"] = json_of(cameras.right);
    json["base_m"] = cameras.base_m;
    const auto& q = cameras.left_from_world.rotation;
    const Eigen::Vector3d centre = centre_of(cameras.left_from_world);
    json["left_from_world_quaternion_wxyz"] = {q.w(), q.x(), q.y(), q.z()};
    json["left_centre_m"] = {centre.x(), centre.y(), centre.z()};
    json["points"] = cameras.points;
  }
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::string stereo_text(const StereoReport& report) {
  std::string text =
      fmt::format("measured: {:.1f} % of {} pixels, {}\n",
                  report.pixels ? 100.0 * double(report.measured) / double(report.pixels) : 0.0, report.pixels,
                  report.median_sigma_px ? fmt::format("median sigma {:.2f} px", *report.median_sigma_px)
                                         : "without standard deviations");
  if (!report.levels.empty()) text += level_table(report.levels);
  if (report.cameras && !report.median_sigma_px) return text + "no cloud: nothing has a standard deviation\n";
  if (report.cameras)
    text += fmt::format("cloud: {} points, {}\n", report.cameras->points,
                        report.frame == PairFrame::kLeftCamera ? "frame of the left camera: x right, y down, z forward"
                                                               : "world frame of the orientation");
  return text;
}

}  // namespace collinea
