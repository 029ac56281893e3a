// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/feature/edges.h"
#include "collinea/feature/hough.h"
#include "collinea/feature/line_corners.h"
#include "collinea/feature/target.h"
#include "collinea/report/edges_report.h"

namespace collinea {

/// What is made of the edges of an image, and where it is written.
struct FindEdgesOptions {
  EdgeFind find = EdgeFind::kChains;
  EdgeOptions edges;
  HoughOptions hough;
  LineCornerOptions corners;
  TargetKind target = TargetKind::kCircle;
  int target_radius_px = 8;
  std::optional<std::filesystem::path> points;
  std::optional<std::filesystem::path> shape;
  std::optional<double> shape_rotation_deg;
  std::optional<std::string> shape_scale;
  double polygon_px = 1;
  double curvature_px = 5;
  bool texture = false;
  int texture_window = 9;
  double entropy = 4;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = FindEdgesOptions;
    visit(Field{"find", &O::find, "", "what is made of the edges"});
    visit(Part{&O::edges});
    visit(Part{&O::hough});
    visit(Part{&O::corners});
    visit(Field{"target", &O::target, "", "with targets: which"});
    visit(Field{"target_radius_px", &O::target_radius_px, "px",
                "with targets: half width of the window of crosses and chequerboards, and of circles at given points",
                4, 500});
    visit(Field{"points", &O::points, "",
                "with targets: table with point, x, y (px) where they are looked for; nothing: in the whole image"}
              .leads_to(PathKind::kFile));
    visit(Field{"shape", &O::shape, "", "with shapes: image of the shape, in whose middle its reference point lies"}
              .leads_to(PathKind::kFile));
    visit(Field{"shape_rotation_deg", &O::shape_rotation_deg, "deg",
                "with shapes: largest rotation; nothing: the shape is not turned", 0, 180});
    visit(
        Field{"shape_scale", &O::shape_scale, "",
              "with shapes: smallest,largest scale against the image of the shape, or one that is known; nothing: 1"});
    visit(Field{"polygon_px", &O::polygon_px, "px", "with chains: largest distance of their polygons from them", 0.01,
                1000});
    visit(Field{"curvature_px", &O::curvature_px, "px",
                "with chains: length on either side of a point over which its curvature is taken", 1, 1000});
    visit(Field{"texture", &O::texture, "", "measures of texture as images, too, and the entropy mask"});
    visit(Field{"texture_window", &O::texture_window, "px", "side of their window, odd", 3, 99});
    visit(Field{"entropy", &O::entropy, "bit", "least entropy of the mask", 0, 8});
  }
};

/// Finds edges in an image and what they draw; tables, an image with what was found, and vectors (GeoPackage and DXF; x
/// right, y up: the row with its sign turned) go into a folder. Errors: files, options.
[[nodiscard]] Result<EdgesReport> find_edges(const std::filesystem::path& image, const std::filesystem::path& folder,
                                             const FindEdgesOptions& options, const Run& run);

}  // namespace collinea
