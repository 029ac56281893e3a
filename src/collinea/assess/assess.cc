// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/assess.h"

#include <fmt/format.h>

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

std::string line(const char* what, const PointErrors& e) {
  return fmt::format(
      "{:<34} {:>5}   RMS east {:.4f}  north {:.4f}  up {:.4f}  3D {:.4f} m   worst {:.4f} m   mean {:+.4f} {:+.4f} "
      "{:+.4f}\n",
      what, e.points, e.rms_m.x(), e.rms_m.y(), e.rms_m.z(), e.rms_3d_m, e.worst_3d_m, e.mean_m.x(), e.mean_m.y(),
      e.mean_m.z());
}

std::string line(const char* what, const HeightErrors& e, double unit_m) {
  return fmt::format(
      "{:<34} {:>9} cells   RMSE {:.4f} m = {:.2f} GSD   NMAD {:.4f} m = {:.2f} GSD   mean {:+.4f} m   gross {:.2f} "
      "%\n",
      what, e.cells, e.rmse_m, e.rmse_m / unit_m, e.nmad_m, e.nmad_m / unit_m, e.mean_m, 100 * e.share_gross);
}

std::string line(const CloudErrors& e) {
  constexpr std::size_t kEnough = 300;  // points
  std::string text = fmt::format(
      "cloud, sigma                       {} points   within 95 % bounds {:.1f} %   beyond 5 sigmas {:.2f} %   RMS of "
      "others in sigmas, by images:",
      e.points, 100 * e.within_bounds, 100 * e.share_gross);
  for (const auto& [images, points, rms] : e.by_images)
    if (points >= kEnough) text += fmt::format(" {}: {:.2f}", images, rms);
  return text + "\n";
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

std::string table(const Assessment& a) {
  std::string text = fmt::format("images oriented                    {} of {}\n", a.poses.oriented, a.poses.images);
  if (a.poses.centres) text += line("projection centres", *a.poses.centres);
  if (a.poses.after_similarity) {
    text += line("projection centres, aligned", *a.poses.after_similarity);
    text += fmt::format("attitudes, aligned                 RMS {:.5f} deg   scale of the alignment {:.8f}\n",
                        a.poses.rotation_rms_deg, a.poses.scale.value_or(1));
  }
  if (a.check_points) text += line("check points", *a.check_points);
  if (a.control_points) text += line("control points", *a.control_points);
  if (a.cloud && a.cloud->points) text += line(*a.cloud);
  if (a.surface) {
    const double unit_m = a.gsd_m.value_or(a.surface->cell_m);
    text += line("surface model, all", a.surface->overall, unit_m);
    text += line("surface model, smooth ground", a.surface->smooth_ground, unit_m);
    if (a.surface->smooth_measured.cells) text += line("  measured cells", a.surface->smooth_measured, unit_m);
    if (a.surface->smooth_interpolated.cells)
      text += line("  interpolated cells", a.surface->smooth_interpolated, unit_m);
    if (a.surface->roofs.cells) text += line("surface model, roofs", a.surface->roofs, unit_m);
    if (a.surface->bounds)
      text += fmt::format(
          "surface model, sigma               {} cells   within 95 % bounds {:.1f} %{}\n", a.surface->bounds,
          100 * a.surface->within_bounds,
          a.surface->roofs.cells ? fmt::format("   on roofs {:.1f} %", 100 * a.surface->roofs_within_bounds) : "");
    if (a.relative_within_bounds)
      text +=
          fmt::format("surface model, relative sigma      less the plane of all errors, within 95 % bounds {:.1f} %\n",
                      100 * *a.relative_within_bounds);
    text += fmt::format(
        "surface model, completeness        {:.2f} %   measured {:.2f} %   where 3 or more images see {:.2f} %   cell "
        "{:.4g} m\n",
        100 * a.surface->completeness, 100 * a.surface->completeness_measured, 100 * a.surface->completeness_seen,
        a.surface->cell_m);
  }
  if (a.walls && a.walls->places) {
    const double unit_m = a.gsd_m.value_or(a.surface->cell_m);
    text += fmt::format(
        "surface model, walls               {} places   RMS {:.4f} m = {:.2f} GSD   median {:.2f} GSD   mean {:+.4f} m "
        "  "
        "within 2 GSD {:.1f} %\n",
        a.walls->places, a.walls->rms_m, a.walls->rms_m / unit_m, a.walls->median_m / unit_m, a.walls->mean_m,
        100 * a.walls->share_within);
  }
  if (a.terrain) {
    const double unit_m = a.gsd_m.value_or(a.terrain->cell_m);
    text += line("terrain model, all", a.terrain->overall, unit_m);
    if (a.terrain->measured.cells) text += line("  ground seen", a.terrain->measured, unit_m);
    if (a.terrain->interpolated.cells) text += line("  interpolated", a.terrain->interpolated, unit_m);
    text += fmt::format("terrain model, objects removed     {:.2f} % of {} cells\n", 100 * a.terrain->share_removed,
                        a.terrain->object_cells);
  }
  if (a.ortho)
    text += fmt::format(
        "orthophoto, local shift            {} windows   RMS x {:.3f}  y {:.3f} px   median {:.3f} px   mean {:+.3f} "
        "{:+.3f}   "
        "over 1 px {:.1f} %   failed {:.1f} %   cell {:.4g} m\n",
        a.ortho->windows, a.ortho->rms_x_px, a.ortho->rms_y_px, a.ortho->median_px, a.ortho->mean_x_px,
        a.ortho->mean_y_px, 100 * a.ortho->share_over_1_px, 100 * a.ortho->share_failed, a.ortho->cell_m);
  if (a.ortho_colours)
    text += fmt::format(
        "orthophoto, colours                {} pixels   wrong surface {:.2f} %   RMS {:.1f} grey   brightness of {} "
        "photographs alike to RMS {:.1f} %, worst {:.1f} %\n",
        a.ortho_colours->pixels, 100 * a.ortho_colours->share_wrong, a.ortho_colours->rms_grey,
        a.ortho_colours->photographs, 100 * a.ortho_colours->gain_rms, 100 * a.ortho_colours->gain_worst);
  return text;
}

}  // namespace collinea
