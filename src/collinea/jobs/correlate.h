// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/match/area_matching.h"
#include "collinea/match/pair_points.h"
#include "collinea/match/relaxation.h"
#include "collinea/match/window_matching.h"
#include "collinea/report/correlate_report.h"

namespace collinea {

struct CorrelateOptions {
  std::optional<std::filesystem::path> points = {};
  std::optional<int> max_points = {};
  std::optional<std::string> parallax_px = {};
  std::optional<std::string> surface_of = {};
  AreaOptions matching = {};
  PointDecision decision = PointDecision::kReturn;
  RelaxationOptions relaxation = {};
  std::optional<WindowModel> refine = {};
  std::optional<std::string> line_px = {};
  std::optional<std::filesystem::path> epipolar = {};
  std::optional<double> refine_return_px = {};
  WindowOptions window = {};

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = CorrelateOptions;
    visit(
        Field{"points", &O::points, "",
              "text table of points of the left image: point x_left y_left [px], and x_right y_right where about they "
              "are expected; nothing: interest points"}
            .leads_to(PathKind::kFile));
    visit(Field{"max_points", &O::max_points, "",
                "interest points that are taken where no table is given; nothing: 200", 1, 1000000});
    visit(Field{"parallax_px", &O::parallax_px, "",
                "dx,dy of left less right, where points are expected; nothing: found near each point by matching from "
                "small images to large ones"});
    visit(Field{"surface_of", &O::surface_of, "",
                "name of a point whose similarities are drawn (surface.svg) and written (surface.tif)"});
    visit(Part{&O::matching});
    visit(Field{"decision", &O::decision, "", "how wrong matches are told from right ones"});
    visit(Field{"refine", &O::refine, "",
                "least squares matching of what is found, and how its window may lie in the right image; nothing: "
                "none"});
    visit(Field{"line_px", &O::line_px, "",
                "dx,dy: direction of the line of refine line, through the position found; nothing: along the rows, as "
                "in epipolar images"});
    visit(Field{"epipolar", &O::epipolar, "",
                "file of three rows with three numbers, the fundamental matrix F of x_right' F x_left = 0 in pixels: "
                "refine line then goes along the epipolar line of each point"}
              .leads_to(PathKind::kFile));
    visit(Field{"refine_return_px", &O::refine_return_px, "px",
                "what is refined, refined back in the left image, must come back so near to the point; of line along "
                "the epipolar line of what was found; nothing: not checked",
                0, 100});
    visit(Group{"refinement", &O::window});
    visit(Group{"relaxation", &O::relaxation});
  }
};

/// Finds points of one image in another by area matching, and writes into `folder`: correlated.txt, left.png and
/// right.png (the images with the points: red found, blue not), refined.txt, surface.svg and surface.tif where asked
/// for. Errors: files, options, columns, images whose parallax is not found, no point of that name; stopped.
[[nodiscard]] Result<CorrelateReport> correlate_points(const std::filesystem::path& left,
                                                       const std::filesystem::path& right,
                                                       const std::filesystem::path& folder,
                                                       const CorrelateOptions& options, const Run& run);

}  // namespace collinea
