// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/base/file.h"
#include "collinea/base/memory.h"
#include "collinea/cloud/las.h"
#include "collinea/edit/read_work.h"
#include "collinea/project/product_frame.h"
#include "collinea/radiometry/view.h"
#include "collinea/raster/block_cache.h"
#include "collinea/raster/hillshade.h"
#include "collinea/steps/cloud_pieces.h"
#include "collinea/steps/step.h"
#include "collinea/surface/dtm.h"

namespace collinea {
namespace {

// Writes the cloud anew: all stays as it is but the classes. Returns how many points show the ground.
Result<std::uint64_t> classify(const Project& project, const GroundSurface& ground) {
  COLLINEA_TRY(LasReader reader, LasReader::open(project.cloud()));
  LasWriter::Options options;
  options.wkt = reader.header().wkt;
  options.like = reader.header();
  options.form = project.settings.densify.cloud;
  options.run = project.run;
  COLLINEA_TRY(LasWriter writer, LasWriter::create(project.cloud(), options));
  std::uint64_t count = 0, done = 0;
  for (;;) {
    COLLINEA_TRY(std::vector<CloudPoint> points, reader.read(kPiecePoints));
    if (points.empty()) break;
    for (CloudPoint& point : points) {
      const bool shows = ground.shows_ground(point.position, double(point.sigma_m));
      point.classification = shows ? kGroundClass : kUnclassified;
      count += shows;
    }
    COLLINEA_TRY(writer.write(points));
    if (project.run.stopped()) return fail(Errc::kCancelled, "cancelled");
    done += points.size();
    project.run.report("terrain: classes", double(done) / double(std::max<std::uint64_t>(1, reader.header().points)));
  }
  COLLINEA_TRY(writer.finish());
  return count;
}

// Whether what people gave a class shows the ground.
Result<GroundByHand> ground_by_hand(const Project& project) {
  COLLINEA_TRY(std::vector<CloudRegion> regions, read_cloud_regions(project));
  CloudEdits edits(regions_of_classes(std::move(regions)));
  if (edits.empty()) return GroundByHand{};
  return GroundByHand([edits = std::move(edits)](const Eigen::Vector3d& on_map) -> std::optional<bool> {
    const auto given = edits.class_at(on_map);
    if (!given) return std::nullopt;
    return *given == kGroundClass;
  });
}

}  // namespace

Result<StepOutput> terrain_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block block, project.store.read_orientation());
  const auto products = project.folder / "products";
  const auto without = [&](FindingCode why) -> Result<StepOutput> {
    for (const char* earlier : {"contours.gpkg", "contours.dxf"}) COLLINEA_TRY(remove_file(products / earlier));
    return StepOutput{inputs_hash, TerrainRecord{.skipped_because = finding_of(why, {Product::kTerrainModel})}};
  };
  if (!looks_down(block)) return without(FindingCode::kNotDownwards);
  COLLINEA_TRY(const ProductFrame product_frame, product_frame_of(project, block));
  if (!product_frame.metric) return without(FindingCode::kNoScale);
  const DsmFiles dsm{products / "dsm.tif",
                     products / "dsm_sigma.tif",
                     products / "dsm_state.tif",
                     {},
                     products / "dsm_sigma_relative.tif"};
  const DtmFiles files{products / "dtm.tif", products / "dtm_sigma.tif", products / "dtm_state.tif",
                       products / "contours.gpkg", products / "dtm_sigma_relative.tif"};
  const BlockCacheLimit cache(kCacheOfPieces);
  COLLINEA_TRY(const GroundByHand by_hand, ground_by_hand(project));
  const auto made = build_dtm(dsm, files, project.settings.terrain, project.run, by_hand);
  if (!made && made.error().code == Errc::kIllPosed) return without(FindingCode::kNoGround);
  if (!made) return tl::unexpected(made.error());
  const DtmSummary& summary = made->summary;
  give_back_freed_memory();
  COLLINEA_TRY(write_hillshade(files.height, products / "dtm_hillshade.tif", project.run));
  give_back_freed_memory();
  COLLINEA_TRY(const std::uint64_t ground_points, classify(project, made->ground));
  return StepOutput{inputs_hash, TerrainRecord{.cell_m = summary.grid.cell_m,
                                               .width = summary.grid.width,
                                               .height = summary.grid.height,
                                               .ground_cells = summary.ground_cells,
                                               .interpolated_cells = summary.interpolated_cells,
                                               .ground_points = ground_points,
                                               .coarse_cell_m = summary.coarse_cell_m,
                                               .lowest_m = summary.lowest_m,
                                               .highest_m = summary.highest_m,
                                               .mean_sigma_m = summary.mean_sigma_m,
                                               .mean_sigma_relative_m = summary.mean_sigma_relative_m,
                                               .contour_m = summary.contour_m,
                                               .contours = summary.contours}};
}

}  // namespace collinea
