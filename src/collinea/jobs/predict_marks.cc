// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/predict_marks.h"

#include <algorithm>

#include "collinea/jobs/marking_project.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/image_window.h"
#include "collinea/restitution/map_height.h"

namespace collinea {

Result<MarksReport> predict_marks(const Project& project, const std::string& point) {
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  const auto named = std::find_if(setup.control.begin(), setup.control.end(),
                                  [&](const auto& entry) { return entry.second.name == point; });
  if (named == setup.control.end()) return fail(Errc::kNotFound, "there is no control point \"" + point + "\"");
  MarksReport report{.point = named->second};
  COLLINEA_TRY(MarkingProject oriented, MarkingProject::read(project));
  std::vector<ControlObservation> marks;
  for (const ControlObservation& mark : setup.control_observations)
    if (mark.point == named->first && oriented.block.images.contains(mark.image)) marks.push_back(mark);
  MarkingBlock marking = oriented.marking();
  marking.surface =
      surface_in_world(oriented.frame_or_null(), heights_by_need(project.folder / "products" / "dsm.tif"));
  report.marks = predicted_marks(marking, report.point, marks);
  report.block = std::move(oriented.block);
  return report;
}

namespace {

// What lies within a reach about a position, cut at the borders of the image.
PixelWindow window_about(const Eigen::Vector2d& near_px, int reach_px, int width_px, int height_px) {
  const int left = std::clamp(int(near_px.x()) - reach_px, 0, width_px - 1);
  const int top = std::clamp(int(near_px.y()) - reach_px, 0, height_px - 1);
  return {left, top, std::min(2 * reach_px + 1, width_px - left), std::min(2 * reach_px + 1, height_px - top)};
}

FloatImage part_of(const FloatImage& image, const PixelWindow& whole, const PixelWindow& part) {
  FloatImage out(part.width, part.height);
  for (int y = 0; y < part.height; ++y)
    std::copy_n(image.row(part.top - whole.top + y) + part.left - whole.left, part.width, out.row(y));
  return out;
}

}  // namespace

Result<RefinedMark> target_in_image(const std::filesystem::path& image, int width_px, int height_px,
                                    const Eigen::Vector2d& near_px, std::optional<MarkedKind> kind) {
  const bool is_inside = near_px.x() >= 0 && near_px.y() >= 0 && near_px.x() <= width_px && near_px.y() <= height_px;
  if (!is_inside)
    return fail(Errc::kBadInput, "the position is not inside the image of " + std::to_string(width_px) + " x " +
                                     std::to_string(height_px) + " pixels");
  const bool may_be_tag = !kind || kind == MarkedKind::kTag;
  const PixelWindow target = window_about(near_px, kRefineReach_px, width_px, height_px);
  const PixelWindow read = may_be_tag ? window_about(near_px, kTagReach_px, width_px, height_px) : target;
  COLLINEA_TRY(const FloatImage grey, read_grey_window(image, width_px, height_px, read));
  PixelWindow of = read;
  auto found = may_be_tag ? tag_near(grey, near_px - Eigen::Vector2d(of.left, of.top)) : std::nullopt;
  if (!found && kind != MarkedKind::kTag) {
    of = target;
    found = refined_mark(part_of(grey, read, target), near_px - Eigen::Vector2d(of.left, of.top),
                         kind ? target_kind(*kind) : std::nullopt);
  }
  if (!found)
    return fail(Errc::kNotConverged, "no target was found within " + std::to_string(int(kLargestMiss_px)) +
                                         " px: mark the point by hand, with its standard deviation");
  found->pixel += Eigen::Vector2d(of.left, of.top);
  return *found;
}

Result<RefinedMark> target_in_file(const std::filesystem::path& image, const Eigen::Vector2d& near_px,
                                   const TargetOptions& options) {
  COLLINEA_TRY(const ImageHeader header, read_image_header(image));
  return target_in_image(image, header.width_px, header.height_px, near_px, options.kind);
}

}  // namespace collinea
