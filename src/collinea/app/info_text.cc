// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/info_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "collinea/app/flags.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/json_values.h"
#include "collinea/report/step_figures.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

json control_points(const AdjustmentRecord& adjustment, const Block& setup) {
  json list = json::array();
  for (const ControlDifference& control : adjustment.control) {
    const auto point = setup.control.find(control.point);
    if (point == setup.control.end()) continue;
    list.push_back({{"name", point->second.name},
                    {"role", control.excluded ? "excluded"
                             : control.used   ? "control"
                                              : "check"},
                    {"images", control.rays},
                    {"difference_m", vector(control.difference_m)},
                    {"sigma_m", vector(control.difference_sigma_m)},
                    {"beyond_3_sigma", is_beyond_3_sigma(control)}});
  }
  return list;
}

json steps(const ProjectInfo& info) {
  json list = json::array();
  for (const StepRecord& step : info.steps)
    list.push_back({{"name", step.name()},
                    {"seconds", step.seconds},
                    {"cpu_seconds", step.cpu_seconds},
                    {"peak_memory_bytes", step.peak_memory_bytes},
                    {"figures", figures_of(step.outcome, info.setup)}});
  return list;
}

std::string axes_text(const std::optional<AxisValues>& rmse) {
  if (!rmse) return "none";
  constexpr int kLeastDecimals = 3, kMostDecimals = 7;
  double largest = 0;
  for (const auto& axis : *rmse) largest = std::max(largest, axis.value_or(0));
  // Two digits of micrometres on a table too.
  const int digits = largest > 0 ? 1 - static_cast<int>(std::floor(std::log10(largest))) : 0;
  const int decimals = std::clamp(digits, kLeastDecimals, kMostDecimals);
  std::string text;
  for (const auto& axis : *rmse)
    text += (text.empty() ? "" : " / ") + (axis ? fmt::format("{:.{}f}", *axis, decimals) : "-");
  return text + " m (east / north / height)";
}

std::string number_text(const std::optional<double>& value, const char* unit) {
  return value ? fmt::format("{:.4g} {}", *value, unit) : "not known yet";
}

}  // namespace

std::string info_json(const ProjectInfo& info) {
  json all = {{"images", info.setup.images.size()},
              {"cameras", info.setup.cameras.size()},
              {"oriented", 0},
              {"tie_points", 0},
              {"observations", 0},
              {"mean_reprojection_px", nullptr},
              {"gsd_m", nullptr},
              {"control_rmse_m", nullptr},
              {"check_rmse_m", nullptr},
              {"control_points", json::array()}};
  if (info.setup.georeference) all["crs"] = info.setup.georeference->crs;
  if (const OrientationRecord* orientation = info.orientation()) {
    all.update(figures_of(*orientation, info.setup));
  }
  if (const AdjustmentRecord* adjustment = info.adjustment()) {
    json findings = all.contains("findings") ? all["findings"] : json::array();
    all.update(figures_of(*adjustment, info.setup));
    for (const json& finding : all["findings"]) findings.push_back(finding);
    all["findings"] = findings;
    all["images"] = info.setup.images.size();
    all["control_points"] = control_points(*adjustment, info.setup);
  }
  all["steps"] = steps(info);
  for (const Step step : info.by_another_version) all["by_another_version"].push_back(word_of(step));
  return all.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string info_text(const ProjectInfo& info) {
  std::string text;
  const auto line = [&](const std::string& name, const std::string& value) {
    text += fmt::format("{:<22} {}\n", name, value);
  };
  const OrientationRecord* found = info.orientation();
  const OrientationRecord orientation = found ? *found : OrientationRecord{};
  line("images", fmt::format("{} ({} oriented)", info.setup.images.size(), orientation.oriented));
  line("cameras", std::to_string(info.setup.cameras.size()));
  line("map", info.setup.georeference ? info.setup.georeference->crs : "none: local gauge");
  const AdjustmentRecord* adjusted = info.adjustment();
  const AdjustmentRecord adjustment = adjusted ? *adjusted : AdjustmentRecord{};
  line("tie points", fmt::format("{} with {} observations", adjusted ? adjustment.tie_points : orientation.tie_points,
                                 adjusted ? adjustment.observations : orientation.observations));
  line("mean reprojection", number_text(adjusted ? std::optional(adjustment.mean_reprojection_px)
                                        : found  ? std::optional(orientation.mean_reprojection_px)
                                                 : std::nullopt,
                                        "px"));
  if (adjusted)
    line("adjustment", fmt::format("sigma0 {:.3f}, redundancy {}", adjustment.sigma0, adjustment.redundancy));
  if (found && !adjusted) line("adjustment", "not adjusted yet: no standard deviations");
  line("ground sample", number_text(orientation.gsd_m(), "m"));
  line("control RMSE", axes_text(adjustment.control_rmse_m));
  line("check RMSE", axes_text(adjustment.check_rmse_m));
  for (const StepRecord& step : info.steps)
    line("step " + step.name(), fmt::format("{:8.1f} s {:8.1f} CPU-s {:6.0f} MB", step.seconds, step.cpu_seconds,
                                            step.peak_memory_bytes / 1e6));
  for (const Step step : info.by_another_version)
    line("step " + std::string(word_of(step)), "made by another version of collinea: run it again");
  for (const auto& findings : {orientation.findings, adjustment.findings})
    for (const Finding& finding : findings) line("note", sentence_of(finding, info.setup, flag_of));
  return text;
}

}  // namespace collinea
