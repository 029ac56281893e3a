// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/words.h"
#include "collinea/feature/line_segments.h"

// Straight edges of the two images of an epipolar pair (what is in a row of one is in the same row of the other) that
// are the same edge of the object (Mussio 7.4, A.26-A.28; Medioni and Nevatia 1985). Where an edge crosses a row it has
// a position to a fraction of a pixel, so that two edges have a disparity in every row that they share: no windows are
// compared, and the jump of depth that often makes an edge does no harm. docs/theory/line-matching.md.
namespace collinea {

struct LineMatchOptions {
  double least_row_angle_deg = 10;
  double largest_rotation_deg = 30;
  double least_overlap = 0.5;
  double grey_sigma = 20;
  double least_similarity = 0.2;
  double decisive_ratio = 1.5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = LineMatchOptions;
    visit(Field{"least_row_angle_deg", &O::least_row_angle_deg, "deg",
                "of a line: least angle with the rows of the epipolar pair; along a row it has no disparity", 1, 80});
    visit(Field{"largest_rotation_deg", &O::largest_rotation_deg, "deg",
                "largest angle between the lines of both images", 1, 90});
    visit(Field{"least_overlap", &O::least_overlap, "1", "part of the shorter line whose rows the other one has, too",
                0, 1});
    visit(Field{"grey_sigma", &O::grey_sigma, "grey",
                "difference of the grey values beside both lines that lowers their similarity to 0.61", 1, 255});
    visit(Field{"least_similarity", &O::least_similarity, "1", "of a candidate", 0, 1});
    visit(Field{"decisive_ratio", &O::decisive_ratio, "1",
                "of several candidates the most similar is taken when the next is so many times less similar; "
                "otherwise neighbours decide",
                1, 1e6});
  }
};

/// A straight edge of one image with the grey values beside it.
struct MatchableLine {
  EdgeLine line;
  SideGreys greys;
};

/// How a line of the left image was decided.
enum class LineOutcome : std::uint8_t { kAlongRows, kNoCandidate, kOne, kDecisive, kByNeighbours, kUndecided };
inline constexpr Word<LineOutcome> kLineOutcomeWords[] = {
    {LineOutcome::kAlongRows, "along_rows", "too near to the direction of the rows"},
    {LineOutcome::kNoCandidate, "no_candidate", "no line of the other image is similar"},
    {LineOutcome::kOne, "one", "matched: each is the only candidate of the other"},
    {LineOutcome::kDecisive, "decisive", "matched: each is by far the most similar candidate of the other"},
    {LineOutcome::kByNeighbours, "by_neighbours", "matched: chosen of several by the disparities around"},
    {LineOutcome::kUndecided, "undecided", "several are alike, or the other line prefers another one"}};
[[nodiscard]] constexpr std::span<const Word<LineOutcome>> words(LineOutcome) { return kLineOutcomeWords; }

/// Two lines that may be the same edge.
struct LineCandidate {
  std::size_t left = 0, right = 0;                 ///< by their order
  double first_row = 0, last_row = 0;              ///< that both have [px]
  double first_disparity = 0, last_disparity = 0;  ///< left less right there [px]
  double overlap = 0;                              ///< of the shorter one
  double rotation_rad = 0;                         ///< angle of the right line less that of the left one
  double similarity = 0;                           ///< 0 to 1

  [[nodiscard]] double middle_disparity() const { return (first_disparity + last_disparity) / 2; }
  [[nodiscard]] double middle_row() const { return (first_row + last_row) / 2; }
};

struct LineDecision {
  LineOutcome outcome = LineOutcome::kNoCandidate;
  std::optional<LineCandidate> match;  ///< where it is matched
  std::size_t candidates = 0;
};

/// Where a line crosses a row: the column, and its standard deviation. Nothing for a line along the rows (1e-6 rad).
struct RowCrossing {
  double column = 0, sigma_px = 0;
};
[[nodiscard]] std::optional<RowCrossing> crossing(const EdgeLine& line, double row);

/// The candidates of all left lines: both cross the rows; the brighter side is the same; the rows that both have are
/// least_overlap of the shorter one, and disparities at their ends lie between `low` and `high`. Similarity is
///     overlap exp(-rotation^2 / 2 (15 deg)^2) (g_darker + g_brighter) / 2,   g = exp(-difference^2 / 2 grey_sigma^2):
/// at the border of an object before a background one side alone stays the same.
[[nodiscard]] std::vector<LineCandidate> line_candidates(std::span<const MatchableLine> left,
                                                         std::span<const MatchableLine> right, double low_px,
                                                         double high_px, const LineMatchOptions& options);

/// Decides for every left line, one to one: first those that are each other's only or decisively best candidate (there
/// and back); then the others by relaxation (match/relaxation.h), in which the nearest of those that are decided bear
/// out candidates of like disparity, again there and back. What stays alike stays undecided.
[[nodiscard]] std::vector<LineDecision> match_lines(std::span<const MatchableLine> left,
                                                    std::span<const MatchableLine> right, double low_px, double high_px,
                                                    const LineMatchOptions& options);

/// A point of the left edge with its position in the right image, where the epipolar line crosses the matched edge.
struct EdgePointMatch {
  Eigen::Vector2d left_px, right_px;
  double sigma_px = 0;  ///< of the disparity: both errors across their edges, over the sine of the angle with the row
};
/// Of each edge point that lies in the rows of the match; points along a row have none.
[[nodiscard]] std::vector<EdgePointMatch> edge_point_matches(const LineCandidate& match,
                                                             std::span<const EdgePoint> left_points,
                                                             const EdgeLine& right);

}  // namespace collinea
