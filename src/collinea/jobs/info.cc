// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/info.h"
#include "collinea/project/json_text.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace collinea {
namespace {

using nlohmann::json;

// Control and check points with their differences, what those are expected to be, and whether they are beyond thrice
// that.
json control_points(const json& orientation, const Block& setup) {
  json list = json::array();
  for (const json& row : orientation.at("details").at("control")) {
    const auto point = setup.control.find(ControlId{row.at("point").get<std::uint32_t>()});
    if (point == setup.control.end()) continue;
    const json &differences = row.at("difference_m"), sigmas = row.value("sigma_m", json::array());
    bool beyond = false;
    for (std::size_t axis = 0; axis < sigmas.size(); ++axis)
      if (differences.at(axis).is_number() && sigmas[axis].is_number())
        beyond |= std::abs(differences[axis].get<double>()) > 3 * sigmas[axis].get<double>();
    list.push_back({{"name", point->second.name},
                    {"role", row.at("excluded").get<bool>() ? "excluded"
                             : row.at("used").get<bool>()   ? "control"
                                                            : "check"},
                    {"images", row.at("rays")},
                    {"difference_m", differences},
                    {"sigma_m", sigmas},
                    {"beyond_3_sigma", beyond}});
  }
  return list;
}

Result<json> gather(const ProjectStore& store) {
  COLLINEA_TRY(const Block setup, store.read_setup());
  COLLINEA_TRY(const std::vector<StepRecord> steps, store.read_steps());
  json info = {{"images", setup.images.size()},
               {"oriented", 0},
               {"tie_points", 0},
               {"observations", 0},
               {"mean_reprojection_px", nullptr},
               {"gsd_m", nullptr},
               {"control_rmse_m", nullptr},
               {"check_rmse_m", nullptr},
               {"control_points", json::array()},
               {"steps", json::array()}};
  for (const StepRecord& step : steps) {
    info["steps"].push_back({{"name", step.name},
                             {"seconds", step.seconds},
                             {"cpu_seconds", step.cpu_seconds},
                             {"peak_memory_bytes", step.peak_memory_bytes}});
    if (step.name != "orient") continue;
    const json orientation = json::parse(step.report_json, nullptr, false);
    for (const auto& [key, value] : orientation.items())
      if (key != "details") info[key] = value;
    if (orientation.contains("details")) info["control_points"] = control_points(orientation, setup);
  }
  info["cameras"] = setup.cameras.size();
  if (setup.georeference) info["crs"] = setup.georeference->crs;
  return info;
}

std::string axes_text(const json& rmse) {
  if (!rmse.is_array()) return "none";
  std::string text;
  for (const json& axis : rmse)
    text += (text.empty() ? "" : " / ") + (axis.is_null() ? "-" : fmt::format("{:.3f}", axis.get<double>()));
  return text + " m (east / north / height)";
}

}  // namespace

Result<std::string> info_json(const ProjectStore& store) {
  COLLINEA_TRY(const json info, gather(store));
  return json_text(info, 2) + "\n";
}

Result<std::string> info_text(const ProjectStore& store) {
  COLLINEA_TRY(const json info, gather(store));
  const auto number = [&](const char* key, const char* unit) {
    return info[key].is_null() ? std::string("not known yet") : fmt::format("{:.4g} {}", info[key].get<double>(), unit);
  };
  std::string text;
  const auto line = [&](const char* name, const std::string& value) {
    text += fmt::format("{:<22} {}\n", name, value);
  };
  line("images", fmt::format("{} ({} oriented)", info["images"].get<int>(), info["oriented"].get<int>()));
  line("cameras", std::to_string(info["cameras"].get<int>()));
  line("map", info.value("crs", std::string("none: local gauge")));
  line("tie points",
       fmt::format("{} with {} observations", info["tie_points"].get<int>(), info["observations"].get<int>()));
  line("mean reprojection", number("mean_reprojection_px", "px"));
  line("ground sample", number("gsd_m", "m"));
  line("control RMSE", axes_text(info["control_rmse_m"]));
  line("check RMSE", axes_text(info["check_rmse_m"]));
  for (const json& step : info["steps"])
    line(("step " + step["name"].get<std::string>()).c_str(),
         fmt::format("{:8.1f} s {:8.1f} CPU-s {:6.0f} MB", step["seconds"].get<double>(),
                     step["cpu_seconds"].get<double>(), step["peak_memory_bytes"].get<double>() / 1e6));
  for (const json& finding : info.value("findings", json::array())) line("note", finding.get<std::string>());
  return text;
}

}  // namespace collinea
