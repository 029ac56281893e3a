// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/feature/edges.h"
#include "collinea/jobs/internal/stereo_pair_options.h"
#include "collinea/match/line_matching.h"
#include "collinea/report/lines_report.h"

namespace collinea {

/// How straight edges of a pair are found and matched.
struct PairLinesOptions {
  EdgeOptions edges;
  int least_points = 25, most = 400;
  double tolerance_px = 1, gap_px = 20;
  bool curves = false;
  LineMatchOptions matching;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PairLinesOptions;
    visit(Part{&O::edges});
    visit(Field{"least_points", &O::least_points, "1", "of a line, edge points", 5, 1e6});
    visit(Field{"most", &O::most, "1", "lines of an image that are looked for", 1, 1e5});
    visit(Field{"tolerance_px", &O::tolerance_px, "px", "largest distance of an edge point from its line", 0.1, 20});
    visit(Field{"gap_px", &O::gap_px, "px", "a line without edge points for longer is cut in two", 1, 1e5});
    visit(Field{"curves", &O::curves, "",
                "match edges of any shape, too, point by point where they cross the rows: curve_points.txt"});
    visit(Group{"matching", &O::matching});
  }
};

/// Straight edges of an oriented pair as lines in space, and writes into `folder`: lines.txt, edge_points.txt,
/// left.png and right.png (the epipolar images; matched lines in like colours), where asked for curve_points.txt, and
/// where the cameras are known lines.gpkg and lines.dxf. Errors: as match_stereo(); no straight edge in one of the
/// images (with curves: no edge that crosses the rows either).
[[nodiscard]] Result<LinesReport> lines_of_pair(const std::string& left, const std::string& right,
                                                const std::filesystem::path& folder, const StereoPairOptions& pair,
                                                const PairLinesOptions& options, const Run& run);

}  // namespace collinea
