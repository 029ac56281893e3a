// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "collinea/match/line_matching.h"

// Edges of any shape of the two images of an epipolar pair that are the same edge of the object: figural continuity
// (Mayhew and Frisby 1981; Ohta and Kanade 1985; Mussio A.26-A.28). An edge is cut where it runs along the rows; each
// piece crosses every row once, so that two of them have a disparity in every row that they share. Nothing is fitted:
// it may bend as it likes. docs/theory/line-matching.md.
namespace collinea {

/// A piece of an edge that crosses every row once, by its points from the upper to the lower ones.
struct EdgeArc {
  std::vector<EdgePoint> points;
  SideGreys greys;
  double along_px = 1;  ///< EdgeMap::along_px

  [[nodiscard]] double first_row() const { return points.front().at.y(); }
  [[nodiscard]] double last_row() const { return points.back().at.y(); }
};

/// The pieces of the chains with `least_points` and more whose normals are `least_row_angle_deg` and more from the
/// direction of the columns; cut at points that `is_left_out` and where neighbours are more than 2 px apart. A closed
/// chain goes on over its first point. Grey values beside are medians 2 to 4 px across. In the order of the chains.
[[nodiscard]] std::vector<EdgeArc> edge_arcs(const EdgeMap& map, const FloatImage& image, double least_row_angle_deg,
                                             int least_points,
                                             const std::function<bool(const Eigen::Vector2d&)>& is_left_out);

/// Where an arc crosses a row, on the straight line between two neighbouring points: the column, its standard
/// deviation along the row with the correlation of both points, and the normal. Nothing beyond its rows. The chord of
/// points a pixel apart is off an edge of radius r by 1 / (8 r) px at most.
struct ArcCrossing {
  double column = 0, sigma_px = 0;
  Eigen::Vector2d normal;
};
[[nodiscard]] std::optional<ArcCrossing> crossing(const EdgeArc& arc, double row);

/// Two arcs that are matched over some rows.
struct ArcMatch {
  std::size_t left = 0, right = 0;                                ///< by their order
  LineOutcome outcome = LineOutcome::kOne;                        ///< kOne, kDecisive or kByNeighbours
  double first_row = 0, last_row = 0;                             ///< that both have [px]
  double lowest_px = 0, highest_px = 0, median_disparity_px = 0;  ///< disparities, left less right
  double rotation_rad = 0;                                        ///< median of the right normals less the left ones
  double similarity = 0;                                          ///< as line_candidates(), with these medians
};

struct ArcMatches {
  std::vector<ArcMatch> matches;  ///< by left arc and row
  std::size_t candidates = 0, undecided = 0;
};

/// Candidates as line_candidates(), the disparity of every row between `low` and `high`. Two of them contradict each
/// other when they have an arc in common and a fifth of the rows of the shorter one: an edge that is broken in one
/// image matches with both of its pieces. Decided is what is decisive_ratio times as similar as all that contradicts
/// it (of two that are as similar none); what is left is decided by relaxation among the nearest decided ones, there
/// and back, as match_lines().
[[nodiscard]] ArcMatches match_arcs(std::span<const EdgeArc> left, std::span<const EdgeArc> right, double low_px,
                                    double high_px, const LineMatchOptions& options);

/// The points of the left arc in the rows of a match, each with its position in the right image.
[[nodiscard]] std::vector<EdgePointMatch> arc_point_matches(const ArcMatch& match, const EdgeArc& left,
                                                            const EdgeArc& right);

}  // namespace collinea
