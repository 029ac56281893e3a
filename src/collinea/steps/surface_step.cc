// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/memory.h"
#include "collinea/project/product_frame.h"
#include "collinea/radiometry/view.h"
#include "collinea/raster/block_cache.h"
#include "collinea/raster/hillshade.h"
#include "collinea/steps/internal/product_records.h"
#include "collinea/steps/left_points.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

PointSource points_of(LeftPoints& cloud) {
  return [&cloud](std::vector<SurfacePoint>& batch) -> Result<> {
    COLLINEA_TRY(const std::vector<CloudPoint> points, cloud.next());
    batch.clear();
    for (const CloudPoint& point : points) batch.push_back({point.position, point.sigma_m, point.images});
    return {};
  };
}

// What images and cameras make of heights, as the adjustment found it.
Result<std::vector<PositionSigma>> orientation_sigmas(const Project& project, const LocalFrame* frame) {
  COLLINEA_TRY(const auto adjusted, project.store.read_outcome<AdjustmentRecord>());
  std::vector<PositionSigma> sigmas;
  for (const PositionPrecision& at : adjusted.position_precision) {
    const Eigen::Vector3d in_world(at.position_in_world.x(), at.position_in_world.y(), 0);
    const Eigen::Vector3d on_map = frame ? frame->map_from_local(in_world) : in_world;
    sigmas.push_back({on_map.x(), on_map.y(), at.sigma_m(Eigen::Vector3d::UnitZ(), adjusted.sigma_scale())});
  }
  return sigmas;
}

}  // namespace

Result<StepOutput> surface_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block block, project.store.read_orientation());
  if (!looks_down(block))
    return StepOutput{inputs_hash, SurfaceRecord{.skipped_because =
                                                     finding_of(FindingCode::kNotDownwards, {Product::kSurfaceModel})}};
  COLLINEA_TRY(const ProductFrame product_frame, product_frame_of(project, block));
  COLLINEA_TRY(const std::vector<PositionSigma> sigmas, orientation_sigmas(project, product_frame.frame_or_null()));
  COLLINEA_TRY(LeftPoints cloud, LeftPoints::open(project));
  const BlockCacheLimit cache(kCacheOfPieces);
  const auto products = project.folder / "products";
  const DsmFiles files{products / "dsm.tif", products / "dsm_sigma.tif", products / "dsm_state.tif",
                       products / "dsm_count.tif", products / "dsm_sigma_relative.tif"};
  COLLINEA_TRY(const DsmSummary summary,
               build_dsm({points_of(cloud), product_frame.frame_or_null(), PointFrame::kMap,
                          product_frame.matched_pixel_m, sigmas},
                         files, project.folder / "scratch", project.settings.surface, project.run));
  give_back_freed_memory();
  COLLINEA_TRY(write_hillshade(files.height, products / "dsm_hillshade.tif", project.run));
  return StepOutput{inputs_hash, surface_record(summary)};
}

}  // namespace collinea
