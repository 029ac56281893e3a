// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "collinea/geodesy/local_frame.h"
#include "collinea/report/report.h"
#include "collinea/steps/internal/files_to_sign.h"
#include "collinea/steps/internal/frame_list.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

void add_adjustment(const AdjustmentRecord& adjustment, const OrientationRecord& orientation, ReportInput& input) {
  input.control = adjustment.control;
  input.positions = adjustment.positions;
  input.geodetic = adjustment.geodetic;
  input.centre_sigma_m = adjustment.centre_sigma_m;
  input.rotation_sigma_rad = adjustment.rotation_sigma_rad;
  for (const auto& [camera, sigma] : adjustment.calibration.sigma) {
    auto& values = input.camera_sigma[camera];
    std::copy_n(sigma.begin(), std::min(values.size(), sigma.size()), values.begin());
  }
  input.sigma0 = adjustment.sigma0;
  input.redundancy = adjustment.redundancy;
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

// The files that are there.
void add_products(const Project& project, ReportInput& input) {
  for (std::size_t i = 0; i < kProductFiles; ++i) {
    const auto product = static_cast<ProductFile>(i);
    std::error_code missing;
    const auto bytes = fs::file_size(project.folder / path_of(product), missing);
    if (!missing) input.products.push_back({product, bytes});
  }
  if (outcome_in<SurfaceRecord>(input.steps).cell_m > 0) input.dsm = project.folder / path_of(ProductFile::kSurface);
  input.frames = frames_folder(project.folder);
  if (outcome_in<OrthoRecord>(input.steps).cell_m > 0) input.ortho = project.folder / path_of(ProductFile::kOrthophoto);
}

// Heights follow the control where it took part; receivers give them above the ellipsoid.
std::optional<HeightReference> height_reference(const ReportInput& input, const OrientationRecord& orientation,
                                                const AdjustmentRecord& adjustment) {
  if (input.crs_name.find(" + ") != std::string::npos) return std::nullopt;  // the name says it
  if (orientation.relative_heights) return HeightReference::kMiddleCamera;
  return adjustment.control_rmse_m ? HeightReference::kControlPoints : HeightReference::kEllipsoid;
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
  COLLINEA_TRY(const auto adjustment, project.store.read_outcome<AdjustmentRecord>());
  add_adjustment(adjustment, orientation, input);
  add_notes(input.steps, input);
  add_products(project, input);
  if (input.block.georeference) {
    COLLINEA_TRY(input.crs_name, check_crs(input.block.georeference->crs));
    input.height_reference = height_reference(input, orientation, adjustment);
  }
  input.options = chosen_options(project.settings);
  input.spelling = project.run.spelling;
  input.versions.emplace_back("collinea", COLLINEA_VERSION);
  input.signer = project.settings.report;
  input.files = SignedFiles{COLLINEA_VERSION, project.settings.seed, files_to_sign(project, setup)};
  COLLINEA_TRY(hash_files(project.folder, input.files->files, project.run));
  COLLINEA_TRY(write_report(input, project.folder / "report"));
  return StepOutput{inputs_hash, ReportRecord{"report/report.html"}};
}

}  // namespace collinea
