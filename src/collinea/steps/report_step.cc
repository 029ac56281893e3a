// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <locale>
#include <nlohmann/json.hpp>

#include "collinea/geodesy/local_frame.h"
#include "collinea/project/places.h"
#include "collinea/report/report.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

Eigen::Vector3d vector_of(const json& list) {
  Eigen::Vector3d vector;
  for (int axis = 0; axis < 3; ++axis) {
    const json& value = list.at(static_cast<std::size_t>(axis));
    vector[axis] = value.is_null() ? std::nan("") : value.get<double>();
  }
  return vector;
}

void add_orientation(const json& orientation, ReportInput& input) {
  const json& details = orientation.at("details");
  for (const json& row : details.at("control"))
    input.control.push_back({.point = ControlId{row.at("point").get<std::uint32_t>()},
                             .used = row.at("used").get<bool>(),
                             .excluded = row.at("excluded").get<bool>(),
                             .rays = row.at("rays").get<int>(),
                             .difference_m = vector_of(row.at("difference_m")),
                             .sigma_m = vector_of(row.at("sigma_m"))});
  for (const json& row : details.at("positions"))
    input.positions.push_back({ImageId{row.at("image").get<std::uint32_t>()}, vector_of(row.at("difference_m")),
                               row.at("weight").get<double>()});
  for (const auto& [image, sigma] : details.at("centre_sigma_m").items())
    input.centre_sigma_m[ImageId{static_cast<std::uint32_t>(std::stoul(image))}] = vector_of(sigma);
  for (const auto& [camera, sigma] : details.at("camera_sigma").items()) {
    auto& values = input.camera_sigma[CameraId{static_cast<std::uint32_t>(std::stoul(camera))}];
    for (std::size_t k = 0; k < std::min(values.size(), sigma.size()); ++k)
      values[k] = sigma.at(k).is_null() ? 0 : sigma.at(k).get<double>();
  }
  input.sigma0 = orientation.at("sigma0").get<double>();
  input.redundancy = orientation.at("redundancy").get<long>();
  for (const json& row : details.value("ground", json::array()))
    input.ground.push_back({.observation = row.at("observation").get<std::uint32_t>(),
                            .used = row.at("used").get<bool>(),
                            .excluded = row.at("excluded").get<bool>(),
                            .adjusted = row.at("adjusted").get<double>(),
                            .difference = row.at("difference").get<double>(),
                            .sigma = row.at("sigma").is_null() ? std::nan("") : row.at("sigma").get<double>()});
  input.georeferenced = orientation.at("georeferenced").get<bool>();
  input.metric = orientation.value("metric", input.georeferenced);
  input.gauge = orientation.at("gauge").get<std::string>();
  if (orientation.at("gsd_m").is_number()) input.gsd_m = orientation.at("gsd_m").get<double>();
}

void add_notes(const std::vector<StepRecord>& steps, ReportInput& input) {
  for (const StepRecord& step : steps) {
    const json report = json::parse(step.report_json, nullptr, false);
    if (!report.is_object()) continue;
    for (const json& photo : report.value("skipped", json::array()))
      input.skipped.push_back({photo.at("file").get<std::string>(), photo.at("reason").get<std::string>()});
    for (const json& finding : report.value("findings", json::array()))
      input.findings.push_back(finding.get<std::string>());
    if (report.contains("skipped_because")) input.findings.push_back(report["skipped_because"].get<std::string>());
  }
}

struct Thousands : std::numpunct<char> {
  char do_thousands_sep() const override { return ','; }
  std::string do_grouping() const override { return "\3"; }
};

std::string cells_text(const json& step) {
  return fmt::format("cells of {:.3g} m, {} x {}", step.value("cell_m", 0.0), step.value("width", 0),
                     step.value("height", 0));
}

void add_products(const Project& project, const std::map<std::string, json>& reports, ReportInput& input) {
  const auto add = [&](const char* name, const std::string& file, const std::string& what) {
    std::error_code missing;
    const auto bytes = fs::file_size(project.folder / file, missing);
    if (!missing) input.products.push_back({name, file, bytes, what});
  };
  const auto of = [&](const char* step) { return reports.contains(step) ? reports.at(step) : json::object(); };
  const std::string points =
      fmt::format(std::locale(std::locale::classic(), new Thousands), "{:L} points", of("densify").value("points", 0l));
  add("Point cloud", "products/cloud.las", points + ", LAS 1.4 in the map, with sigmas");
  add("Point cloud", "products/cloud.laz", points + ", LAZ 1.4 in the map, with sigmas");
  add("Point cloud", "products/cloud.copc.laz", points + ", COPC 1.0 (LAZ 1.4) in the map, with sigmas");
  add("Point cloud", "products/cloud.ply", points + ", PLY in the local frame, with normals");
  add("Surface model", "products/dsm.tif", cells_text(of("surface")));
  add("Surface model, standard deviations", "products/dsm_sigma.tif", "m");
  add("Surface model, relative standard deviations", "products/dsm_sigma_relative.tif", "m, against heights around");
  add("Surface model, state", "products/dsm_state.tif", "0 nothing, 1 measured, 2 interpolated");
  add("Surface model, count", "products/dsm_count.tif", "points that made a cell");
  add("Surface model, hillshade", "products/dsm_hillshade.tif", "light from the north-west");
  add("Terrain model", "products/dtm.tif", cells_text(of("terrain")));
  add("Terrain model, standard deviations", "products/dtm_sigma.tif", "m");
  add("Terrain model, relative standard deviations", "products/dtm_sigma_relative.tif", "m, against heights around");
  add("Terrain model, state", "products/dtm_state.tif", "0 nothing, 1 ground as measured, 2 interpolated");
  add("Terrain model, hillshade", "products/dtm_hillshade.tif", "light from the north-west");
  const std::string contours = fmt::format("every {:.4g} m, with heights", of("terrain").value("contour_m", 0.0));
  add("Contours", "products/contours.gpkg", contours + ", GeoPackage");
  add("Contours", "products/contours.dxf", contours + ", DXF");
  add("Orthophoto", "products/ortho.tif", cells_text(of("ortho")) + ", Cloud-Optimised GeoTIFF");
  add("Orthophoto, sources", "products/ortho_source.tif", "index of the leading photograph");
  if (of("surface").contains("cell_m")) input.dsm = project.folder / "products/dsm.tif";
  if (of("ortho").contains("cell_m")) input.ortho = project.folder / "products/ortho.tif";
}

// The folder's name, also of "." and "project/".
std::string title_of(const Project& project) {
  std::error_code error;
  fs::path folder = fs::absolute(project.folder, error).lexically_normal();
  if (folder.filename().empty()) folder = folder.parent_path();
  return folder.filename().string();
}

// Heights follow the control where it took part; receivers give them above the ellipsoid.
std::string height_reference(const ReportInput& input, const json& orientation) {
  if (input.crs_name.find(" + ") != std::string::npos) return "";  // the name says it
  if (orientation.at("relative_heights").get<bool>()) return "relative, zero at the middle camera";
  return orientation.at("control_rmse_m").is_null() ? "above the WGS 84 ellipsoid" : "as those of the control points";
}

}  // namespace

Result<StepOutput> report_step(Project& project, const std::string& inputs_hash) {
  ReportInput input;
  COLLINEA_TRY(input.block, project.store.read_block());
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  COLLINEA_TRY(input.steps, project.store.read_steps());
  input.title = title_of(project);
  input.first_cameras = setup.cameras;
  std::map<std::string, json> reports;
  for (const StepRecord& step : input.steps) reports[step.name] = json::parse(step.report_json, nullptr, false);
  add_orientation(reports.at("orient"), input);
  add_notes(input.steps, input);
  add_products(project, reports, input);
  if (input.block.georeference) {
    COLLINEA_TRY(input.crs_name, check_crs(input.block.georeference->crs));
    input.height_reference = height_reference(input, reports.at("orient"));
  }
  input.options = chosen_options(project.settings);
  if (input.options.empty()) input.options.emplace_back("all", "as by default");
  input.versions.emplace_back("collinea", COLLINEA_VERSION);
  COLLINEA_TRY(write_report(input, project.folder / "report"));
  return StepOutput{inputs_hash, "{}", "report/report.html"};
}

}  // namespace collinea
