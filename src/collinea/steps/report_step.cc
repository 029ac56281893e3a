// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <locale>

#include "collinea/geodesy/local_frame.h"
#include "collinea/report/report.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

void add_orientation(const OrientationRecord& orientation, ReportInput& input) {
  input.control = orientation.control;
  input.positions = orientation.positions;
  input.ground = orientation.ground;
  input.centre_sigma_m = orientation.centre_sigma_m;
  for (const auto& [camera, sigma] : orientation.calibration.sigma) {
    auto& values = input.camera_sigma[camera];
    std::copy_n(sigma.begin(), std::min(values.size(), sigma.size()), values.begin());
  }
  input.sigma0 = orientation.sigma0;
  input.redundancy = orientation.redundancy;
  input.georeferenced = orientation.georeferenced;
  input.metric = orientation.metric;
  input.gauge = orientation.gauge;
  input.gsd_m = orientation.gsd_m();
}

void append(auto& all, const auto& more) { all.insert(all.end(), more.begin(), more.end()); }

void add_notes(const std::vector<StepRecord>& steps, ReportInput& input) {
  for (const StepRecord& step : steps) {
    std::visit(
        [&](const auto& record) {
          if constexpr (requires { record.skipped; }) append(input.skipped, record.skipped);
          if constexpr (requires { record.findings; }) append(input.findings, record.findings);
        },
        step.outcome);
    if (const auto why = skipped_because(step.outcome)) input.findings.push_back(*why);
  }
}

struct Thousands : std::numpunct<char> {
  char do_thousands_sep() const override { return ','; }
  std::string do_grouping() const override { return "\3"; }
};

// The record among those of the steps; as nothing was made when the step is not done.
template <class Record>
Record outcome_in(const std::vector<StepRecord>& steps) {
  for (const StepRecord& step : steps)
    if (const auto* record = std::get_if<Record>(&step.outcome)) return *record;
  return {};
}

std::string cells_text(const auto& raster) {
  return fmt::format("cells of {:.3g} m, {} x {}", raster.cell_m, raster.width, raster.height);
}

/// Lists the files that are there.
class ProductList {
 public:
  ProductList(const Project& project, ReportInput& input) : project_(project), input_(input) {}

  void add(const char* name, const std::string& file, const std::string& what) {
    std::error_code missing;
    const auto bytes = fs::file_size(project_.folder / file, missing);
    if (!missing) input_.products.push_back({name, file, bytes, what});
  }

 private:
  const Project& project_;
  ReportInput& input_;
};

void add_clouds(const DensifyRecord& densify, ProductList& list) {
  const std::string points =
      fmt::format(std::locale(std::locale::classic(), new Thousands), "{:L} points", densify.points);
  list.add("Point cloud", "products/cloud.las", points + ", LAS 1.4 in the map, with sigmas");
  list.add("Point cloud", "products/cloud.laz", points + ", LAZ 1.4 in the map, with sigmas");
  list.add("Point cloud", "products/cloud.copc.laz", points + ", COPC 1.0 (LAZ 1.4) in the map, with sigmas");
  list.add("Point cloud", "products/cloud.ply", points + ", PLY in the local frame, with normals");
}

void add_surface(const SurfaceRecord& surface, ProductList& list) {
  list.add("Surface model", "products/dsm.tif", cells_text(surface));
  list.add("Surface model, standard deviations", "products/dsm_sigma.tif", "m");
  list.add("Surface model, relative standard deviations", "products/dsm_sigma_relative.tif",
           "m, against heights around");
  list.add("Surface model, state", "products/dsm_state.tif", "0 nothing, 1 measured, 2 interpolated");
  list.add("Surface model, count", "products/dsm_count.tif", "points that made a cell");
  list.add("Surface model, hillshade", "products/dsm_hillshade.tif", "light from the north-west");
}

void add_terrain(const TerrainRecord& terrain, ProductList& list) {
  list.add("Terrain model", "products/dtm.tif", cells_text(terrain));
  list.add("Terrain model, standard deviations", "products/dtm_sigma.tif", "m");
  list.add("Terrain model, relative standard deviations", "products/dtm_sigma_relative.tif",
           "m, against heights around");
  list.add("Terrain model, state", "products/dtm_state.tif", "0 nothing, 1 ground as measured, 2 interpolated");
  list.add("Terrain model, hillshade", "products/dtm_hillshade.tif", "light from the north-west");
  const std::string contours = fmt::format("every {:.4g} m, with heights", terrain.contour_m);
  list.add("Contours", "products/contours.gpkg", contours + ", GeoPackage");
  list.add("Contours", "products/contours.dxf", contours + ", DXF");
}

void add_products(const Project& project, ReportInput& input) {
  ProductList list(project, input);
  const auto surface = outcome_in<SurfaceRecord>(input.steps);
  const auto ortho = outcome_in<OrthoRecord>(input.steps);
  add_clouds(outcome_in<DensifyRecord>(input.steps), list);
  add_surface(surface, list);
  add_terrain(outcome_in<TerrainRecord>(input.steps), list);
  list.add("Orthophoto", "products/ortho.tif", cells_text(ortho) + ", Cloud-Optimised GeoTIFF");
  list.add("Orthophoto, sources", "products/ortho_source.tif", "index of the leading photograph");
  if (surface.cell_m > 0) input.dsm = project.folder / "products/dsm.tif";
  if (ortho.cell_m > 0) input.ortho = project.folder / "products/ortho.tif";
}

// The folder's name, also of "." and "project/".
std::string title_of(const Project& project) {
  std::error_code error;
  fs::path folder = fs::absolute(project.folder, error).lexically_normal();
  if (folder.filename().empty()) folder = folder.parent_path();
  return folder.filename().string();
}

// Heights follow the control where it took part; receivers give them above the ellipsoid.
std::string height_reference(const ReportInput& input, const OrientationRecord& orientation) {
  if (input.crs_name.find(" + ") != std::string::npos) return "";  // the name says it
  if (orientation.relative_heights) return "relative, zero at the middle camera";
  return orientation.control_rmse_m ? "as those of the control points" : "above the WGS 84 ellipsoid";
}

}  // namespace

Result<StepOutput> report_step(Project& project, const std::string& inputs_hash) {
  ReportInput input;
  COLLINEA_TRY(input.block, project.store.read_block());
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  COLLINEA_TRY(input.steps, project.store.read_steps());
  input.title = title_of(project);
  input.first_cameras = setup.cameras;
  COLLINEA_TRY(const auto orientation, project.store.read_outcome<OrientationRecord>());
  add_orientation(orientation, input);
  add_notes(input.steps, input);
  add_products(project, input);
  if (input.block.georeference) {
    COLLINEA_TRY(input.crs_name, check_crs(input.block.georeference->crs));
    input.height_reference = height_reference(input, orientation);
  }
  input.options = chosen_options(project.settings);
  if (input.options.empty()) input.options.emplace_back("all", "as by default");
  input.versions.emplace_back("collinea", COLLINEA_VERSION);
  COLLINEA_TRY(write_report(input, project.folder / "report"));
  return StepOutput{inputs_hash, ReportRecord{"report/report.html"}};
}

}  // namespace collinea
