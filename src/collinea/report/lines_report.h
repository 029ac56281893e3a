// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "collinea/epipolar/line_intersection.h"
#include "collinea/io/text_table.h"
#include "collinea/match/curve_matching.h"
#include "collinea/match/line_matching.h"
#include "collinea/report/stereo_report.h"

namespace collinea {

/// A matched line in space, as long as both images have it.
struct MatchedSpaceLine {
  SpaceLine line;
  double from_m = 0, to_m = 0;  ///< along it, at the first and the last row that both images have
};

/// A straight edge of the left epipolar image and what became of it.
struct PairLine {
  EdgeLine left;
  LineDecision decision;
  std::optional<EdgeLine> right;          ///< where it is matched
  std::optional<MatchedSpaceLine> space;  ///< where the cameras are known and the planes of rays meet
  std::vector<EdgePointMatch> points;
};

/// Edges of any shape: pieces that cross the rows once, and which of them are the same edge over which rows.
struct PairCurves {
  struct Curve {
    ArcMatch match;
    std::vector<EdgePointMatch> points;
  };
  std::size_t left = 0, right = 0;  ///< pieces
  std::size_t undecided = 0;        ///< candidates that nothing decides
  std::vector<Curve> curves;
};

struct LinesReport {
  std::string left, right;  ///< images
  int low_px = 0, high_px = 0;
  std::size_t right_lines = 0;
  std::vector<PairLine> lines;
  std::optional<PairCurves> curves = {};         ///< where asked for
  std::optional<StereoReport::Cameras> cameras;  ///< of the epipolar pair
  PairFrame frame{};                             ///< of the coordinates in space

  [[nodiscard]] std::size_t matched() const;
  [[nodiscard]] std::size_t in_space() const;
};

/// A row a line of the left image: outcome, end points, rows, disparities with standard deviations, what was compared,
/// end points in space with the standard deviations across the line.
[[nodiscard]] TextTable lines_table(const LinesReport& report);
/// A row an edge point of a matched line: positions in both images, standard deviation of the disparity, depth.
[[nodiscard]] TextTable edge_points_table(const LinesReport& report);
/// The same of the matched pieces of edges of any shape, with how each was decided.
[[nodiscard]] TextTable curve_points_table(const LinesReport& report);
[[nodiscard]] std::string lines_text(const LinesReport& report);  ///< for a terminal

}  // namespace collinea
