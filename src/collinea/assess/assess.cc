// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/assess.h"

#include <memory>

#include "collinea/base/file.h"
#include "collinea/block/world_frame.h"

namespace collinea {
namespace {

bool there(const std::filesystem::path& path) { return !path.empty() && is_there(path); }

// Through geographic coordinates, since the two world frames may have different origins and maps.
Result<ToTruth> to_truth_of(const Block& block, const TruthFolder& truth) {
  if (!block.georeference) return ToTruth{};
  COLLINEA_TRY(const LocalFrame from, world_frame(*block.georeference));
  COLLINEA_TRY(const LocalFrame to, world_frame(truth.georeference));
  return ToTruth{
      [from, to](const Eigen::Vector3d& p) { return to.local_from_geographic(from.geographic_from_local(p)); }};
}

Block true_block(const TruthFolder& truth) {
  Block block;
  block.cameras[CameraId{0}] = truth.camera;
  for (const auto& [file, pose] : truth.cam_from_world) {
    const ImageId id{std::uint32_t(block.images.size())};
    block.images[id].file = file;
    block.images[id].camera = CameraId{0};
    set_pose(block, id, pose);
  }
  return block;
}

Result<std::function<Result<Raster<std::uint8_t>>(int, int, int, int)>> byte_reader(const std::filesystem::path& path,
                                                                                    MapGrid* grid) {
  COLLINEA_TRY(GeoTiffReader opened, GeoTiffReader::open(path));
  const auto reader = std::make_shared<GeoTiffReader>(std::move(opened));
  if (grid) *grid = reader->grid();
  return [reader](int column, int row, int width, int height) { return reader->read_byte(column, row, width, height); };
}

// By one of the rasters of sigmas; who sees what is only looked at where `views` are given.
Result<SurfaceErrors> assess_surface(const ProductFiles& products, const std::filesystem::path& sigma,
                                     const TruthFolder& truth, const LocalFrame& frame, std::span<const View> views,
                                     const Run& run) {
  COLLINEA_TRY(const HeightField model, open_height_field(products.dsm, sigma));
  COLLINEA_TRY(const HeightField expected, open_height_field(truth.dsm));
  StateReader state;
  if (there(products.dsm_state)) {
    COLLINEA_TRY(state, byte_reader(products.dsm_state, nullptr));
  }
  HeightField terrain;
  if (there(truth.dtm)) {
    COLLINEA_TRY(terrain, open_height_field(truth.dtm));
  }
  return surface_errors(model, state, expected, views, &frame, run, terrain.read ? &terrain : nullptr);
}

Result<WallErrors> assess_walls(const ProductFiles& products, const TruthFolder& truth, const Run& run) {
  COLLINEA_TRY(const HeightField model, open_height_field(products.dsm));
  COLLINEA_TRY(const HeightField expected, open_height_field(truth.dsm));
  return wall_errors(model, expected, expected.grid.cell_m, run);
}

Result<TerrainErrors> assess_terrain(const ProductFiles& products, const TruthFolder& truth, const Run& run) {
  COLLINEA_TRY(const HeightField model, open_height_field(products.dtm));
  COLLINEA_TRY(const StateReader state, byte_reader(products.dtm_state, nullptr));
  COLLINEA_TRY(const HeightField terrain, open_height_field(truth.dtm));
  COLLINEA_TRY(const HeightField surface, open_height_field(truth.dsm));
  return terrain_errors(model, state, terrain, surface, run);
}

Result<OrthoErrors> assess_ortho(const ProductFiles& products, const TruthFolder& truth, const Run& run) {
  ImageField product, expected;
  COLLINEA_TRY(product.read, byte_reader(products.ortho, &product.grid));
  COLLINEA_TRY(expected.read, byte_reader(truth.ortho, &expected.grid));
  return ortho_errors(product, expected, run);
}

Result<ColourErrors> assess_colours(const ProductFiles& products, const TruthFolder& truth, const Run& run) {
  ImageField product, expected;
  COLLINEA_TRY(product.read, byte_reader(products.ortho, &product.grid));
  COLLINEA_TRY(expected.read, byte_reader(truth.ortho, &expected.grid));
  SourceReader sources;
  if (there(products.ortho_source)) {
    COLLINEA_TRY(GeoTiffReader opened, GeoTiffReader::open(products.ortho_source));
    const auto reader = std::make_shared<GeoTiffReader>(std::move(opened));
    sources = [reader](int column, int row, int width, int height) {
      return reader->read_float(column, row, width, height);
    };
  }
  return colour_errors(product, sources, expected, run);
}

}  // namespace

Result<Assessment> assess(const Block& block, const ProductFiles& products, const TruthFolder& truth, const Run& run) {
  Assessment result;
  COLLINEA_TRY(const ToTruth to_truth, to_truth_of(block, truth));
  result.poses = pose_errors(block, truth.cam_from_world, to_truth);
  std::map<std::string, Eigen::Vector3d> marks;
  for (const auto& [name, mark] : truth.marks) marks[name] = mark.position_in_world;
  if (to_truth) {
    const PointErrors check = mark_errors(block, ControlRole::kCheck, marks, to_truth);
    const PointErrors control = mark_errors(block, ControlRole::kControl, marks, to_truth);
    if (check.points > 0) result.check_points = check;
    if (control.points > 0) result.control_points = control;
  }
  if (there(truth.dsm)) {
    COLLINEA_TRY(const GeoTiffReader reader, GeoTiffReader::open(truth.dsm));
    result.gsd_m = reader.grid().cell_m;
  }
  if (there(products.cloud) && there(truth.dsm)) {
    COLLINEA_TRY(const HeightField expected, open_height_field(truth.dsm));
    COLLINEA_TRY(result.cloud, cloud_errors(products.cloud, expected, run));
  }
  if (there(products.dsm) && there(truth.dsm)) {
    COLLINEA_TRY(const LocalFrame frame, world_frame(truth.georeference));
    COLLINEA_TRY(result.surface,
                 assess_surface(products, products.dsm_sigma, truth, frame, views_of(true_block(truth), &frame), run));
    if (there(products.dsm_sigma_relative)) {
      COLLINEA_TRY(const SurfaceErrors by_relative,
                   assess_surface(products, products.dsm_sigma_relative, truth, frame, {}, run));
      result.relative_within_bounds = by_relative.levelled_within_bounds;
    }
    COLLINEA_TRY(result.walls, assess_walls(products, truth, run));
  }
  if (there(products.dtm) && there(products.dtm_state) && there(truth.dtm) && there(truth.dsm)) {
    COLLINEA_TRY(result.terrain, assess_terrain(products, truth, run));
  }
  if (there(products.ortho) && there(truth.ortho)) {
    COLLINEA_TRY(result.ortho, assess_ortho(products, truth, run));
    COLLINEA_TRY(result.ortho_colours, assess_colours(products, truth, run));
  }
  return result;
}

}  // namespace collinea
