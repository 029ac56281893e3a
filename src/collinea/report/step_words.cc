// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/step_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/report/finding_words.h"
#include "collinea/report/internal/counted.h"

namespace collinea {
namespace {

std::string words(const std::vector<FilmScanRecord>& film) {
  if (film.empty()) return "";
  double squares = 0;
  for (const FilmScanRecord& scan : film) squares += scan.rms_um * scan.rms_um;
  return fmt::format(", film: marks within {:.1f} um RMS", std::sqrt(squares / double(film.size())));
}

std::string words(const ImportRecord& r) {
  return fmt::format("{}, {}, {}, {}{}{}", counted(r.images, "image"), counted(r.cameras, "camera"),
                     counted(r.positions, "position"), counted(r.control_points, "control point"),
                     r.geodetic_observations == 0
                         ? ""
                         : ", " + counted(r.geodetic_observations, "measurement") + " on the ground",
                     r.crs ? ", map " + *r.crs : ", no map: local gauge") +
         words(r.film);
}

std::string words(const DetectRecord& r) {
  return counted(r.features, "feature") + " in " + counted(r.images, "image");
}

std::string words(const MatchRecord& r) {
  return fmt::format("{} verified, {} searched, {} matches", counted(r.pairs_by_geometry.verified(), "pair"),
                     r.pairs_searched, r.matches);
}

std::string words(const OrientationRecord& r) {
  return fmt::format("{} of {} images, {} tie points, mean residual {:.2f} px, {}", r.oriented, r.images, r.tie_points,
                     r.mean_reprojection_px, words_of(r.gauge));
}

std::string words(const AdjustmentRecord& r) {
  return fmt::format("sigma0 {:.3f}, redundancy {}, mean residual {:.2f} px{}{}", r.sigma0, r.redundancy,
                     r.mean_reprojection_px, r.mismatches == 0 ? "" : fmt::format(", {} mismatches", r.mismatches),
                     r.rejected == 0 ? "" : ", " + counted(r.rejected, "measurement") + " rejected");
}

std::string words(const DensifyRecord& r) {
  return counted(r.depth_maps, "depth map") + ", " + counted(r.points, "point");
}

std::string words(const SurfaceRecord& r) {
  const double seen = double(r.measured_cells + r.interpolated_cells);
  return fmt::format("{} x {} cells of {:.3g} m, {:.1f} % of the seen ones interpolated", r.width, r.height, r.cell_m,
                     seen > 0 ? 100 * double(r.interpolated_cells) / seen : 0.0);
}

std::string words(const TerrainRecord& r) {
  return fmt::format("ground seen in {:.1f} % of {} x {} cells{}",
                     100 * double(r.ground_cells) / double(r.ground_cells + r.interpolated_cells), r.width, r.height,
                     r.contour_m > 0 ? fmt::format(", contours every {:.4g} m", r.contour_m) : std::string());
}

std::string words(const OrthoRecord& r) {
  std::string follows;
  if (r.seamlines) {
    std::uint64_t not_followed = 0;
    for (const auto& [image, cells] : r.cells_not_followed) not_followed += cells;
    follows = fmt::format(", as {} of {} {} but for {:.2f} % of the cells, which their photograph does not see",
                          counted(r.seamlines->polygons, "polygon"), r.seamlines->file,
                          r.seamlines->polygons == 1 ? "says" : "say",
                          100 * double(not_followed) / double(std::max<std::uint64_t>(1, r.painted_cells)));
  }
  return fmt::format(
      "{} x {} cells of {:.3g} m from {}, {:.0f} m of seams along which these differ by "
      "{:.1f} grey levels{}",
      r.width, r.height, r.cell_m, counted(r.images_used, "photograph"), r.seam_length_m, r.seam_difference_grey,
      follows);
}

std::string words(const FramesRecord& r) {
  if (!r.looked_for) return "the map shows it all";
  if (r.frames.empty()) return "no plane that two images see from the front";
  std::string text = counted(r.frames.size(), "plane");
  for (const FrameRecord& frame : r.frames)
    text += fmt::format("{} {} {:.1f} x {:.1f} {}", &frame == &r.frames.front() ? ":" : ",", frame.name, frame.width_m,
                        frame.height_m, r.metric ? "m" : "units");
  return text;
}

std::string words(const ReportRecord& r) { return r.file; }

}  // namespace

std::string summary_of(const StepOutcome& outcome) {
  if (const auto why = skipped_because(outcome)) return sentence_of(*why, {});
  return std::visit([](const auto& record) { return words(record); }, outcome);
}

}  // namespace collinea
