// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/line_segments.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/feature/edges.h"
#include "collinea/feature/test_shapes.h"

namespace collinea {
namespace {

using Eigen::Vector2d;

// A bright field on the right of x = 40.3 with a gap of grey rows in it.
FloatImage two_windows(double noise_grey = 0) {
  return render_shape(
      90, 120,
      [](const Vector2d& p) {
        const double in_gap = blurred_step(p.y() - 50, 0.7) * blurred_step(80 - p.y(), 0.7);
        return blurred_step(p.x() - 40.3, 0.7) * (1 - in_gap);
      },
      noise_grey);
}

std::vector<FoundLine> upright(const EdgeMap& map) {
  std::vector<FoundLine> out;
  for (FoundLine& line : hough_lines(edge_points_of(map), {.least_points = 15}))
    if (std::abs(line.line.theta_rad) < 0.1) out.push_back(std::move(line));
  return out;
}

TEST(LineSegments, ALineIsCutWhereItHasNoPoints) {
  const EdgeMap map = detect_edges(two_windows(), {});
  const auto whole = upright(map);
  ASSERT_EQ(whole.size(), 1u);
  const auto pieces = line_segments(edge_points_of(map), whole, 10, 15);
  ASSERT_EQ(pieces.size(), 2u);
  EXPECT_EQ(line_segments(edge_points_of(map), whole, 60, 15).size(), 1u);
  std::size_t points = 0;
  for (const FoundLine& piece : pieces) {
    EXPECT_NEAR(piece.line.distance_px({40.3, 60}), 0, 0.1);
    EXPECT_NEAR(piece.line.length_px(), piece.points.front() == whole[0].points.front() ? 50 : 40, 12);
    points += piece.points.size();
  }
  EXPECT_EQ(points, whole[0].points.size());
}

TEST(LineSegments, GreysAreThoseBesideTheLine) {
  const FloatImage image = two_windows();
  const EdgeMap map = detect_edges(image, {});
  for (const FoundLine& piece : line_segments(edge_points_of(map), upright(map), 10, 15)) {
    const auto greys = side_greys(image, piece.line);
    ASSERT_TRUE(greys);
    EXPECT_NEAR(greys->darker, 50, 1);
    EXPECT_NEAR(greys->brighter, 170, 1);
  }
  EdgeLine outside{.from = {-30, 5}, .to = {-30, 50}};
  EXPECT_FALSE(side_greys(image, outside));
}

// The distance of a true point from lines through noisy edges, over its sigma: a mean square of 1, of 60 images whose
// two pieces are independent. Standard deviation sqrt(2 / 120).
TEST(LineSegments, SigmaAcrossIsThatOfTheErrors) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const EdgeMap map = detect_edges(with_noise(two_windows(), 6, seed), {.noise_grey = 6});
    for (const FoundLine& piece : line_segments(edge_points_of(map), upright(map), 10, 15)) {
      const Vector2d at(40.3, piece.line.from.y());
      sum += std::pow(piece.line.distance_px(at) / sigma_across(piece.line, at), 2);
      ++count;
    }
  }
  EXPECT_GE(count, 118);
  EXPECT_NEAR(sum / count, 1, 4 * std::sqrt(2.0 / count));
}

}  // namespace
}  // namespace collinea
