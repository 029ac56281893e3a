// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/edit/read_work.h"
#include "collinea/project/product_frame.h"
#include "collinea/project/seamlines_file.h"
#include "collinea/radiometry/view.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/internal/kept_orthophoto_file.h"
#include "collinea/steps/internal/product_records.h"
#include "collinea/steps/step.h"

namespace collinea {

namespace {

// Seamlines that were found are written for editing; those that were given are written, too, as they were understood,
// so that the products tell what was used, unless they are that very file.
Result<> keep_seamlines(const Project& project, const Block& block, const OrthoSummary& summary) {
  const auto path = project.folder / "products" / "seamlines.gpkg";
  const auto& given = project.settings.ortho.seamlines;
  std::error_code differs;
  if (given && std::filesystem::equivalent(*given, path, differs)) return {};
  return write_seamlines(path, summary.seamlines, block, summary.sources, summary.grid.wkt);
}

OrthoRecord record_of(const Project& project, const OrthoSummary& summary, const std::vector<SeamPolygon>& given) {
  OrthoRecord record = ortho_record(summary);
  if (const auto& file = project.settings.ortho.seamlines) record.seamlines = GivenSeamlines{*file, given.size()};
  return record;
}

// In the order in which they lie over each other. One of a photograph without orientation cannot be made.
std::vector<SeamPolygon> patches_of(const Project& project, const Block& block, const EditedWork& work) {
  std::vector<SeamPolygon> patches;
  const auto oriented = oriented_images(block);
  for (const SeamPatch& patch : work.patches) {
    const auto at = std::ranges::find(oriented, patch.image, [](const auto& one) { return one.image; });
    if (at == oriented.end()) {
      project.run.say(
          fmt::format("note: patch {} is left out: {} is not oriented", patch.name, block.images.at(patch.image).file));
      continue;
    }
    patches.push_back({std::uint16_t(at - oriented.begin() + 1), {patch.ring_m}});
  }
  return patches;
}

Result<std::string> inputs_but_patches(const Project& project, const ImageMasks& masks) {
  Hash hash;
  hash.add(COLLINEA_VERSION).add(options_text(project.settings, "ortho"));
  if (const auto& given = project.settings.ortho.seamlines) hash.add(std::uint64_t{hash_of_file(*given).value_or(0)});
  for (const char* earlier : {"adjust", "surface", "terrain"}) {
    COLLINEA_TRY(const auto record, project.store.read_step(earlier));
    hash.add(record ? record->output_hash : "");
  }
  return hash.add(masks.text()).hex();
}

}  // namespace

Result<StepOutput> ortho_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block block, project.store.read_orientation());
  if (!looks_down(block))
    return StepOutput{inputs_hash,
                      OrthoRecord{.skipped_because = finding_of(FindingCode::kNotDownwards, {Product::kOrthophoto})}};
  COLLINEA_TRY(const ProductFrame product_frame, product_frame_of(project, block));
  const auto products = project.folder / "products";
  COLLINEA_TRY(const HeightField surface, open_height_field(products / "dsm.tif", products / "dsm_sigma.tif"));
  // Seams avoid what is raised above the terrain; without a terrain model the surface's own steps must do.
  HeightField terrain;
  if (is_there(products / "dtm.tif")) {
    COLLINEA_TRY(terrain, open_height_field(products / "dtm.tif"));
  }
  const auto pixels = [&](ImageId image, int shrink) {
    return read_colour(project.image_file(block.images.at(image)), shrink);
  };
  SeamGuides guides;
  if (terrain.read) guides.terrain = &terrain;
  COLLINEA_TRY(const EditedWork work, read_work(project));
  const ImageMasks masks = masks_of(work);
  guides.masks = &masks;
  guides.patches = patches_of(project, block, work);
  std::vector<SeamPolygon> given;
  if (const auto& path = project.settings.ortho.seamlines) {
    std::vector<ImageId> oriented;
    for (const auto& [image, pose] : oriented_images(block)) oriented.push_back(image);
    COLLINEA_TRY(given, read_seamlines(*path, block, oriented, surface.grid.wkt));
    guides.given = &given;
  }
  const OrthoFiles files{products / "ortho.tif", products / "ortho_source.tif"};
  COLLINEA_TRY(const std::string inputs, inputs_but_patches(project, masks));
  const auto earlier = read_kept(project.folder, inputs, files);
  if (earlier) guides.earlier = &*earlier;
  COLLINEA_TRY(const OrthoSummary summary,
               make_orthophoto(block, product_frame.frame_or_null(), surface, guides, pixels, product_frame.pixel_m,
                               files, project.settings.ortho, project.run));
  COLLINEA_TRY(keep_seamlines(project, block, summary));
  COLLINEA_TRY(write_kept(project.folder, inputs, files, summary.kept));
  if (summary.kept_tiles > 0)
    project.run.say(
        fmt::format("ortho: {} of {} tiles kept from before", summary.kept_tiles, summary.kept.tallies.size()));
  return StepOutput{inputs_hash, record_of(project, summary, given)};
}

}  // namespace collinea
