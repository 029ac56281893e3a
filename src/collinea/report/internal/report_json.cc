// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/report_json.h"

#include "collinea/block/geodetic_words.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/finding_json.h"
#include "collinea/report/json_values.h"
#include "collinea/report/step_figures.h"
#include "collinea/report/value_words.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

json optional(const std::optional<double>& value) { return value ? number(*value) : json(nullptr); }

json rms(const AxisRms& rms) {
  if (rms.points == 0) return nullptr;
  return {{"points", rms.points},
          {"east", optional(rms.axis_m[0])},
          {"north", optional(rms.axis_m[1])},
          {"height", optional(rms.axis_m[2])},
          {"spatial", optional(rms.spatial_m)}};
}

json cameras(const ReportInput& input) {
  json list = json::array();
  for (const auto& [id, camera] : input.block.cameras) {
    json entry = {{"name", camera.name},
                  {"width_px", camera.width_px},
                  {"height_px", camera.height_px},
                  {"source", words_of(camera.prior.source)},
                  {"calibrated", camera.prior.calibrate}};
    const auto first = input.first_cameras.find(id);
    const auto sigma = input.camera_sigma.find(id);
    if (!is<Brown>(camera.model)) entry["model"] = name_of(camera.model);
    if (camera.additional != AdditionalSet::kNone)
      entry["additional"] = kAdditionalNames[std::size_t(camera.additional)];
    for (const int param : params_of(camera)) {
      const auto i = std::size_t(param);
      json value = {{"value", number(camera.params[i])}, {"unit", param_unit(param)}};
      if (first != input.first_cameras.end()) value["before"] = number(first->second.params[i]);
      if (sigma != input.camera_sigma.end()) value["sigma"] = number(sigma->second[i]);
      entry["parameters"][param_name(param)] = value;
    }
    list.push_back(entry);
  }
  return list;
}

json images(const ReportInput& input, const ReportSummary& summary) {
  std::map<ImageId, const PositionDifference*> positions;
  for (const PositionDifference& position : input.positions) positions[position.image] = &position;
  json list = json::array();
  for (const ImageResiduals& residuals : summary.residuals.images) {
    const ImageId id = residuals.image;
    json entry = {{"file", input.block.images.at(id).file},
                  {"observations", residuals.observations},
                  {"rms_px", number(residuals.rms_px)},
                  {"centre_in_world", vector(centre_of(pose_of(input.block, id)))}};
    if (const auto sigma = input.centre_sigma_m.find(id); sigma != input.centre_sigma_m.end())
      entry["centre_sigma_m"] = vector(sigma->second);
    if (const auto position = positions.find(id); position != positions.end()) {
      entry["position_difference_m"] = vector(position->second->difference_m);
      entry["position_weight"] = number(position->second->weight);
    }
    list.push_back(entry);
  }
  return list;
}

json control(const ReportInput& input) {
  json list = json::array();
  for (const ControlDifference& control : input.control)
    list.push_back({{"name", input.block.control.at(control.point).name},
                    {"role", control.excluded ? "excluded"
                             : control.used   ? "control"
                                              : "check"},
                    {"images", control.rays},
                    {"difference_m", vector(control.difference_m)},
                    {"sigma_m", vector(control.difference_sigma_m)},
                    {"rms_px", number(control_rms_px(input.block, control))}});
  return list;
}

json geodetic_json(const ReportInput& input) {
  json list = json::array();
  for (const GeodeticDifference& one : input.geodetic) {
    const GeodeticObservation& measured = input.block.geodetic.at(one.observation);
    list.push_back({{"measurement", words_of(measured, input.block)},
                    {"role", one.excluded ? "excluded"
                             : one.used   ? "control"
                                          : "check"},
                    {"unit", measured.is_angle() ? "rad" : "m"},
                    {"given", measured.value},
                    {"sigma_given", measured.sigma},
                    {"adjusted", number(one.adjusted)},
                    {"difference", number(one.difference)},
                    {"sigma", number(one.difference_sigma)}});
  }
  return list;
}

json pairs(const NamedValues& list) {
  json object = json::object();
  for (const auto& [name, value] : list) object[name] = value;
  return object;
}

json steps(const ReportInput& input) {
  json list = json::array();
  for (const StepRecord& step : input.steps) {
    list.push_back({{"name", step.name()},
                    {"seconds", number(step.seconds)},
                    {"cpu_seconds", number(step.cpu_seconds)},
                    {"peak_memory_bytes", number(step.peak_memory_bytes)},
                    {"figures", figures_of(step.outcome, input.block)}});
  }
  return list;
}

json left_out(const ReportInput& input, const ReportSummary& summary) {
  json list = json::array();
  for (const Finding& skipped : input.skipped)
    list.push_back({{"file", words_of(skipped.subjects.at(0), input.block)},
                    {"code", word_of(skipped.code)},
                    {"reason", reason_of(skipped, input.block)}});
  for (const ImageId id : summary.not_oriented)
    list.push_back({{"file", input.block.images.at(id).file}, {"reason", "not oriented"}});
  return list;
}

json residual_figures(const ResidualStatistics& r) {
  json rays = json::array();
  for (const std::size_t n : r.rays) rays.push_back(n);
  return {{"observations", r.observations},
          {"mean_px", number(r.mean_px)},
          {"rms_coordinate_px", number(r.rms_px)},
          {"largest_px", number(r.largest_px)},
          {"tie_points_by_images", rays}};
}

}  // namespace

std::string report_json(const ReportInput& input, const ReportSummary& s) {
  json products = json::array();
  for (const ReportProduct& product : input.products)
    products.push_back({{"name", name_of(product.file)},
                        {"file", path_of(product.file)},
                        {"bytes", product.bytes},
                        {"what", content_of(product.file, input.steps)}});
  const json report = {{"title", input.title},
                       {"date", input.date},
                       {"statement", s.statement},
                       {"cautions", s.cautions},
                       {"findings", findings_json(input.findings, input.block)},
                       {"georeferenced", input.georeferenced},
                       {"crs", input.block.georeference ? json(input.block.georeference->crs) : json(nullptr)},
                       {"crs_name", input.crs_name},
                       {"gauge", input.gauge ? json(words_of(*input.gauge)) : json(nullptr)},
                       {"length_unit", s.unit},
                       {"images", input.block.images.size()},
                       {"oriented", count_oriented(input.block)},
                       {"tie_points", input.block.points.size()},
                       {"sigma0", number(input.sigma0)},
                       {"redundancy", input.redundancy},
                       {"gsd_m", optional(input.gsd_m)},
                       {"area_seen_by_3_images", number(s.overlap.area(3))},
                       {"check_rmse_m", rms(s.check)},
                       {"control_rmse_m", rms(s.control)},
                       {"position_rms_m", rms(s.position)},
                       {"residuals", residual_figures(s.residuals)},
                       {"control_points", control(input)},
                       {"geodetic", geodetic_json(input)},
                       {"cameras", cameras(input)},
                       {"image_list", images(input, s)},
                       {"left_out", left_out(input, s)},
                       {"products", products},
                       {"steps", steps(input)},
                       {"options", pairs(chosen_options(input))},
                       {"versions", pairs(input.versions)}};
  return report.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace collinea
