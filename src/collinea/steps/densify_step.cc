// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <functional>
#include <limits>
#include <span>

#include "collinea/base/file.h"
#include "collinea/base/hash.h"
#include "collinea/base/memory.h"
#include "collinea/base/units.h"
#include "collinea/cloud/las.h"
#include "collinea/cloud/ply.h"
#include "collinea/dense/fuse.h"
#include "collinea/dense/match.h"
#include "collinea/edit/read_work.h"
#include "collinea/project/depth_folder.h"
#include "collinea/project/product_frame.h"
#include "collinea/raster/image_file.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

using MakeMap = std::function<Result<DepthMap>(ImageId image, const Run& run)>;

// Maps of the images of a list; those found in the folder are kept. Only geometry may be the reason that an image has
// none: what else goes wrong may go right when the command is given again, and would change the products then.
Result<UnitsDone> make_maps(const Project& project, const UnitList& list, DepthFolder& folder, const MakeMap& make) {
  const UnitJob job{.is_done = [&](std::size_t i) { return folder.has(list.units[i].image()); },
                    .work = [&](std::size_t i, const Run& run) -> Result<UnitWorked> {
                      const ImageId image = list.units[i].image();
                      auto map = make(image, run);
                      if (!map && map.error().code == Errc::kIllPosed) return UnitWorked{std::move(map).error()};
                      if (!map) return tl::unexpected(std::move(map).error());
                      COLLINEA_TRY(folder.write(image, *map));
                      return UnitWorked{};
                    }};
  COLLINEA_TRY(UnitsDone done, run_units(project.run, list, job));
  say_kept(project.run, list, done);
  return done;
}

UnitList list_of(const char* stage, UnitKind kind, const std::vector<ImageId>& images) {
  UnitList list{.stage = stage};
  for (const ImageId image : images) list.units.push_back(Unit::of(kind, image));
  return list;
}

// Overviews of all images first, then depth maps. Returns the images that have one.
Result<std::vector<ImageId>> match_all(const Project& project, const Block& block, const TieView& ties,
                                       WorkingImages& sources, DepthFolder& overviews, DepthFolder& folder,
                                       std::vector<Finding>& left_out) {
  std::vector<ImageId> images;
  for (const auto& [image, pose] : oriented_images(block)) images.push_back(image);
  const DenseOptions& options = project.settings.densify;
  SharedBudget costs = budget_for_costs(options, project.run.threads);
  COLLINEA_TRY(make_maps(
      project, list_of("densify: overviews", UnitKind::kOverview, images), overviews,
      [&](ImageId image, const Run& run) { return overview(block, image, ties, sources, costs, options, run); }));
  COLLINEA_TRY(const UnitsDone maps, make_maps(project, list_of("densify: depth maps", UnitKind::kDepthMap, images),
                                               folder, [&](ImageId image, const Run& run) {
                                                 return depth_map(block, image, ties, sources, costs, &overviews,
                                                                  options, run);
                                               }));
  std::vector<ImageId> with_map;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (const auto why = maps.skipped_because.find(i); why != maps.skipped_because.end())
      left_out.push_back(finding_of(FindingCode::kNoDepthMap, {images[i]}, {}, {}, why->second.message));
    else
      with_map.push_back(images[i]);
  }
  return with_map;
}

// What depth maps are made from. Options of fusion leave them alone.
Result<std::string> inputs_of_depth_maps(const Project& project, const ImageMasks& masks) {
  COLLINEA_TRY(const auto adjusted, project.store.read_step("adjust"));
  COLLINEA_CHECK(adjusted.has_value());
  Settings settings = project.settings;
  settings.densify = options_of_matching(settings.densify);
  Hash hash;
  hash.add(COLLINEA_VERSION).add("depth maps").add(options_text(settings, "densify")).add(adjusted->output_hash);
  if (!masks.empty()) hash.add(masks.text());
  return hash.hex();
}

// Where on the map the tie points lie.
struct Extent {
  Eigen::Vector3d lowest = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), highest = -lowest;
};

// Leaves the tie points on disk.
Result<TieView> read_ties(const Project& project, const Block& block, const ProductFrame& product_frame,
                          Extent& extent) {
  COLLINEA_TRY(TieView ties, TieView::on_disk(block, project.folder / "depth" / "ties"));
  auto read =
      project.store.read_ties(block, [&](PointId, const TiePoint& point, std::span<const Observation> observations) {
        const Eigen::Vector3d& position = point.position_in_world;
        const Eigen::Vector3d on_map = product_frame.frame ? product_frame.frame->map_from_local(position) : position;
        extent.lowest = extent.lowest.cwiseMin(on_map);
        extent.highest = extent.highest.cwiseMax(on_map);
        ties.add(position, observations);
      });
  if (!read) return tl::unexpected(std::move(read).error());
  return ties;
}

// The cloud in the map and, where it is asked for, as PLY in the world frame, both at once.
class CloudFiles {
 public:
  static Result<CloudFiles> create(const Project& project, const Extent& of_ties, const ProductFrame& product_frame) {
    const std::filesystem::path products = project.folder / "products";
    LasWriter::Options las;
    las.lowest = of_ties.lowest;
    las.highest = of_ties.highest;
    if (product_frame.frame) las.wkt = product_frame.frame->wkt1();
    las.form = project.settings.densify.cloud;
    las.run = project.run;
    // A new cloud has no classes: the step that writes them must not count as done.
    for (const char* earlier : {"cloud.las", "cloud.laz", "cloud.copc.laz", "cloud.ply", "dtm.tif"})
      COLLINEA_TRY(remove_file(products / earlier));
    COLLINEA_TRY(LasWriter las_writer, LasWriter::create(project.cloud(), las));
    CloudFiles files(std::move(las_writer), product_frame);
    if (project.settings.densify.ply) {
      COLLINEA_TRY(PlyWriter ply_writer, PlyWriter::create(products / "cloud.ply", kLocalCloudComment));
      files.ply_.emplace(std::move(ply_writer));
    }
    return files;
  }

  Result<> write(std::span<const FusedPoint> points) {
    std::vector<Eigen::Vector3d> on_map;
    std::vector<CloudPoint> cloud;
    for (const FusedPoint& point : points) {
      on_map.push_back(point.position_in_world);
      cloud.push_back({point.position_in_world, point.normal_in_world, point.colour, point.sigma, point.images, 0});
    }
    if (ply_) ply_->write(cloud);
    if (positions_.frame) positions_.frame->map_from_local(on_map);
    for (std::size_t i = 0; i < cloud.size(); ++i) cloud[i].position = on_map[i];
    return las_.write(cloud);
  }

  Result<> finish() {
    if (ply_) COLLINEA_TRY(ply_->finish());
    return las_.finish();
  }

 private:
  CloudFiles(LasWriter las, const ProductFrame& product_frame) : las_(std::move(las)), positions_(product_frame) {}
  LasWriter las_;
  std::optional<PlyWriter> ply_;
  const ProductFrame& positions_;
};

}  // namespace

Result<StepOutput> densify_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block block, project.store.read_orientation());
  COLLINEA_TRY(const ProductFrame product_frame, product_frame_of(project, block));
  COLLINEA_TRY(const ImageMasks masks, read_masks(project));
  const auto file = [&](ImageId image) { return project.image_file(block.images.at(image)); };
  WorkingImages sources(
      block, [&](ImageId image, int shrink) { return read_grey(file(image), shrink); }, project.settings.densify,
      masks);
  COLLINEA_TRY(const std::string made_from, inputs_of_depth_maps(project, masks));
  COLLINEA_TRY(DepthFolder folder, DepthFolder::open(project.folder / "depth", made_from, block, sources));
  COLLINEA_TRY(DepthFolder overviews,
               DepthFolder::open(project.folder / "depth" / "overview", made_from, block, sources));
  Extent of_ties;
  COLLINEA_TRY(const TieView ties, read_ties(project, block, product_frame, of_ties));
  DensifyRecord record;
  COLLINEA_TRY(const std::vector<ImageId> images,
               match_all(project, block, ties, sources, overviews, folder, record.skipped));
  sources.clear();
  give_back_freed_memory();

  COLLINEA_TRY(CloudFiles cloud, CloudFiles::create(project, of_ties, product_frame));
  COLLINEA_TRY(const FuseReport fused, fuse(
                                           block, ties, images, folder,
                                           [&](ImageId image, int shrink) { return read_colour(file(image), shrink); },
                                           [&](std::span<const FusedPoint> points) { return cloud.write(points); },
                                           project.settings.densify, project.run));
  COLLINEA_TRY(cloud.finish());
  record.depth_maps = images.size();
  record.points = std::uint64_t(fused.points);
  return StepOutput{inputs_hash, record};
}

}  // namespace collinea
