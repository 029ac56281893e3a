// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/io/text_table.h"
#include "collinea/match/area_matching.h"
#include "collinea/match/window_matching.h"

namespace collinea {

/// A point of the left image and what was found of it in the right one.
struct CorrelatedPoint {
  std::string name;
  Eigen::Vector2d left_px{0, 0}, expected_px{0, 0};
  AreaOutcome outcome = AreaOutcome::kOutside;
  std::optional<AreaMatch> match;
  std::size_t candidates = 0;
  std::optional<double> probability = {};   ///< of the best candidate, where neighbours decide
  std::optional<WindowMatch> refined = {};  ///< by least squares matching, where that was asked for and it was found

  std::optional<double> refined_returned_px = {};  ///< distance from the point when refined back
  std::optional<double> off_line_px = {};          ///< distance of the area match from the epipolar line

  [[nodiscard]] bool is_refined() const { return refined && refined->outcome == WindowOutcome::kFound; }
};

struct CorrelateReport {
  std::string left, right;  ///< files
  AreaOptions options;
  std::optional<WindowModel> refine = {};
  WindowOptions window = {};  ///< of the refinement
  std::optional<double> refine_return_px = {};
  bool has_epipolar_lines = false;
  Eigen::Vector2d parallax_px{0, 0};  ///< left less right, where points are expected without a position of their own
  bool is_parallax_found = false;     ///< by matching on small images
  bool is_relaxed = false;            ///< neighbours decide
  std::vector<CorrelatedPoint> points;
};

/// A row a point: position on the left, what became of it, position on the right with standard deviations, similarity,
/// distance on the way back, candidates.
[[nodiscard]] TextTable correlated_table(const CorrelateReport& report);
/// A row a point that was found: what became of its least squares matching, position with standard deviations, noise,
/// parameters with standard deviations, and their covariances.
[[nodiscard]] TextTable refined_windows_table(const CorrelateReport& report);
/// For a terminal: how many points ended how, precision, the first rows.
[[nodiscard]] std::string correlate_text(const CorrelateReport& report);
/// A picture by itself: the similarities round the expected position as shades, and their profiles through the best one
/// along row and column.
[[nodiscard]] std::string correlation_svg(const CorrelationSurface& surface, const std::string& point);

}  // namespace collinea
