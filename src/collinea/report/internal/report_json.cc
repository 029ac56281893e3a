// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/report_json.h"

#include <numbers>

#include "collinea/block/geodetic_words.h"
#include "collinea/report/internal/cells.h"
#include "collinea/report/internal/details.h"
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

std::vector<ImageDetail> image_details(const ReportInput& input, const ReportSummary& summary) {
  std::map<ImageId, const PositionDifference*> positions;
  for (const PositionDifference& position : input.positions) positions[position.image] = &position;
  std::vector<ImageDetail> details;
  for (const ImageResiduals& residuals : summary.residuals.images) {
    ImageDetail& one = details.emplace_back();
    one.image = residuals.image;
    one.rays = std::size_t(residuals.observations);
    one.rms_px = residuals.rms_px;
    one.centre_in_world = centre_of(pose_of(input.block, one.image));
    if (const auto sigma = input.centre_sigma_m.find(one.image); sigma != input.centre_sigma_m.end())
      one.centre_sigma_m = sigma->second;
    if (const auto sigma = input.rotation_sigma_rad.find(one.image); sigma != input.rotation_sigma_rad.end())
      one.rotation_sigma_deg = 180 / std::numbers::pi * sigma->second;
    if (const auto position = positions.find(one.image); position != positions.end()) one.position = position->second;
  }
  return details;
}

json images(const ReportInput& input, const ReportSummary& summary) {
  json list = json::array();
  for (const ImageDetail& image : image_details(input, summary)) list.push_back(json_of(image, input.block));
  return list;
}

json cameras(const ReportInput& input, const ReportSummary& summary) {
  std::map<CameraId, CameraDetail> details = by_camera(image_details(input, summary), input.block);
  json list = json::array();
  for (const auto& [id, camera] : input.block.cameras) {
    CameraDetail& one = details[id];
    one.camera = id;
    if (const auto first = input.first_cameras.find(id); first != input.first_cameras.end())
      one.before = &first->second;
    if (const auto sigma = input.camera_sigma.find(id); sigma != input.camera_sigma.end())
      one.sigma.assign(sigma->second.begin(), sigma->second.end());
    list.push_back(json_of(one, input.block));
  }
  return list;
}

json control(const ReportInput& input) {
  json list = json::array();
  for (const ControlDifference& one : input.control) list.push_back(json_of(one, input.block));
  return list;
}

json signature(const ReportInput& input) {
  json one = {
      {"surveyor", input.signer.surveyor}, {"licence", input.signer.licence}, {"signed_on", input.signer.signed_on}};
  if (!input.files) return one;
  one["collinea"] = input.files->version;
  one["seed"] = input.files->seed;
  one["inputs_sha256"] = digest_of(*input.files, SignedPart::kInputs);
  one["products_sha256"] = digest_of(*input.files, SignedPart::kProducts);
  return one;
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
                       {"cameras", cameras(input, s)},
                       {"image_list", images(input, s)},
                       {"left_out", left_out(input, s)},
                       {"products", products},
                       {"steps", steps(input)},
                       {"options", pairs(chosen_options(input))},
                       {"versions", pairs(input.versions)},
                       {"signature", signature(input)}};
  return report.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace collinea
