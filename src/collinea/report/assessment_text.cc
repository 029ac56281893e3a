// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/assessment_text.h"

#include <fmt/format.h>

namespace collinea {
namespace {

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

std::string orientation_lines(const Assessment& a) {
  std::string text = fmt::format("images oriented                    {} of {}\n", a.poses.oriented, a.poses.images);
  if (a.poses.centres) text += line("projection centres", *a.poses.centres);
  if (a.poses.after_similarity) {
    text += line("projection centres, aligned", *a.poses.after_similarity);
    text += fmt::format("attitudes, aligned                 RMS {:.5f} deg   scale of the alignment {:.8f}\n",
                        a.poses.rotation_rms_deg, a.poses.scale.value_or(1));
  }
  if (a.check_points) text += line("check points", *a.check_points);
  if (a.control_points) text += line("control points", *a.control_points);
  return text;
}

std::string cloud_line(const CloudErrors& e) {
  constexpr std::size_t kEnough = 300;  // points
  std::string text = fmt::format(
      "cloud, sigma                       {} points   within 95 % bounds {:.1f} %   beyond 5 sigmas {:.2f} %   RMS of "
      "others in sigmas, by images:",
      e.points, 100 * e.within_bounds, 100 * e.share_gross);
  for (const auto& [images, points, rms] : e.by_images)
    if (points >= kEnough) text += fmt::format(" {}: {:.2f}", images, rms);
  return text + "\n";
}

std::string surface_lines(const SurfaceErrors& e, const std::optional<double>& relative_within_bounds, double unit_m) {
  std::string text = line("surface model, all", e.overall, unit_m);
  text += line("surface model, smooth ground", e.smooth_ground, unit_m);
  if (e.smooth_measured.cells) text += line("  measured cells", e.smooth_measured, unit_m);
  if (e.smooth_interpolated.cells) text += line("  interpolated cells", e.smooth_interpolated, unit_m);
  if (e.roofs.cells) text += line("surface model, roofs", e.roofs, unit_m);
  if (e.bounds)
    text += fmt::format("surface model, sigma               {} cells   within 95 % bounds {:.1f} %{}\n", e.bounds,
                        100 * e.within_bounds,
                        e.roofs.cells ? fmt::format("   on roofs {:.1f} %", 100 * e.roofs_within_bounds) : "");
  if (relative_within_bounds)
    text +=
        fmt::format("surface model, relative sigma      less the plane of all errors, within 95 % bounds {:.1f} %\n",
                    100 * *relative_within_bounds);
  return text + fmt::format(
                    "surface model, completeness        {:.2f} %   measured {:.2f} %   where 3 or more images see "
                    "{:.2f} %   cell {:.4g} m\n",
                    100 * e.completeness, 100 * e.completeness_measured, 100 * e.completeness_seen, e.cell_m);
}

std::string wall_line(const WallErrors& e, double unit_m) {
  return fmt::format(
      "surface model, walls               {} samples   RMS {:.4f} m = {:.2f} GSD   median {:.2f} GSD   mean {:+.4f} m  "
      " within 2 GSD {:.1f} %\n",
      e.samples, e.rms_m, e.rms_m / unit_m, e.median_m / unit_m, e.mean_m, 100 * e.share_within);
}

std::string terrain_lines(const TerrainErrors& e, double unit_m) {
  std::string text = line("terrain model, all", e.overall, unit_m);
  if (e.measured.cells) text += line("  ground seen", e.measured, unit_m);
  if (e.interpolated.cells) text += line("  interpolated", e.interpolated, unit_m);
  return text + fmt::format("terrain model, objects removed     {:.2f} % of {} cells\n", 100 * e.share_removed,
                            e.object_cells);
}

std::string ortho_line(const OrthoErrors& e) {
  return fmt::format(
      "orthophoto, local shift            {} windows   RMS x {:.3f}  y {:.3f} px   median {:.3f} px   mean {:+.3f} "
      "{:+.3f}   over 1 px {:.1f} %   failed {:.1f} %   cell {:.4g} m\n",
      e.windows, e.rms_x_px, e.rms_y_px, e.median_px, e.mean_x_px, e.mean_y_px, 100 * e.share_over_1_px,
      100 * e.share_failed, e.cell_m);
}

std::string colour_line(const ColourErrors& e) {
  return fmt::format(
      "orthophoto, colours                {} pixels   wrong surface {:.2f} %   RMS {:.1f} grey   brightness of {} "
      "photographs alike to RMS {:.1f} %, worst {:.1f} %\n",
      e.pixels, 100 * e.share_wrong, e.rms_grey, e.images, 100 * e.gain_rms, 100 * e.gain_worst);
}

}  // namespace

std::string assessment_text(const Assessment& a) {
  const double surface_unit_m = a.surface ? a.gsd_m.value_or(a.surface->cell_m) : 0;
  std::string text = orientation_lines(a);
  if (a.cloud && a.cloud->points) text += cloud_line(*a.cloud);
  if (a.surface) text += surface_lines(*a.surface, a.relative_within_bounds, surface_unit_m);
  if (a.walls && a.walls->samples) text += wall_line(*a.walls, surface_unit_m);
  if (a.terrain) text += terrain_lines(*a.terrain, a.gsd_m.value_or(a.terrain->cell_m));
  if (a.ortho) text += ortho_line(*a.ortho);
  if (a.ortho_colours) text += colour_line(*a.ortho_colours);
  return text;
}

}  // namespace collinea
