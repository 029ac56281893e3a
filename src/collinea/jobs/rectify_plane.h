// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/report/rectified_report.h"

namespace collinea {

/// What makes the plane of an image or of a block, and how it is drawn.
struct RectifyOptions {
  std::optional<std::filesystem::path> points = {};
  std::optional<std::string> rectangle = {}, size = {};
  std::optional<std::filesystem::path> project = {}, orientation = {};
  std::optional<double> focal_px = {};
  std::optional<std::string> control = {};
  std::optional<std::filesystem::path> map_points = {};
  std::optional<std::string> region = {};
  std::optional<double> tolerance_m = {};
  std::optional<std::string> extent = {};
  std::optional<double> cell_m = {};
  std::optional<double> sigma_px = {}, sigma_m = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = RectifyOptions;
    visit(Field{"points", &O::points, "",
                "of a photograph: file with name, column_px, row_px, x_m, y_m of four points of the plane or more in "
                "each line, and sigma_px, sigma_m where they differ; x to the right, y up"}
              .leads_to(PathKind::kFile));
    visit(Field{"rectangle", &O::rectangle, "",
                "of a photograph: column,row of the corners of a rectangle: upper left, upper right, lower right, "
                "lower left"});
    visit(Field{"size", &O::size, "", "width,height of that rectangle in metres"});
    visit(Field{"project", &O::project, "",
                "of a photograph: oriented project that holds it, for the lens distortion and the position of the "
                "camera"}
              .leads_to(PathKind::kFolder));
    visit(Field{"orientation", &O::orientation, "", "the same from a folder with a COLMAP model (text or binary)"}
              .leads_to(PathKind::kFolder));
    visit(Field{"focal_px", &O::focal_px, "px",
                "focal length, where no project knows the camera: for the error off the plane; nothing: from the "
                "perspective of the points",
                1, 1e7});
    visit(Field{"control", &O::control, "",
                "of a project: names of three surveyed points of the plane or more, separated by commas"});
    visit(Field{"map_points", &O::map_points, "",
                "of a project: file with easting, northing, height of three points of the plane or more"}
              .leads_to(PathKind::kFile));
    visit(Field{"region", &O::region, "",
                "of a project: west,south,east,north[,lowest,highest] of the part of the cloud in which the largest "
                "plane is looked for"});
    visit(Field{"tolerance_m", &O::tolerance_m, "m",
                "with region: largest distance of the plane's points from it; nothing: three times the median "
                "standard deviation of the points",
                1e-6, 1e6});
    visit(
        Field{"extent", &O::extent, "",
              "left,bottom,right,top in metres on the plane; nothing: around the points, a tenth wider on each side"});
    visit(Field{"cell_m", &O::cell_m, "m", "cell of the image; nothing: the pixel of the photograph in its middle",
                1e-6, 1e6});
    visit(Field{"sigma_px", &O::sigma_px, "px",
                "of the image coordinates of a photograph's points that state none; nothing: 0.5", 1e-6, 1e4});
    visit(Field{"sigma_m", &O::sigma_m, "m", "of their plane coordinates; nothing: 0", 0, 1e4});
  }
};

/// Draws a plane at a metric scale, from an image (file) or an oriented project (folder), into `out` (.tif or .png)
/// and states its quality in a JSON file of the same name. Errors: options, files, geometry.
[[nodiscard]] Result<RectifiedReport> rectify_plane(const std::filesystem::path& source,
                                                    const std::filesystem::path& out, const RectifyOptions& options,
                                                    const Run& run);

}  // namespace collinea
